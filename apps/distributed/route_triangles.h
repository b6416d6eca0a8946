// Hands every rank the triangles that touch its cells, and finds which touch which.
#pragma once

#include "distributed/mesh_slice.h"
#include "distributed/routed_forest.h"
#include "distributed/world.h"
#include "octree/coarse_bins.h"
#include "proxima/grow_cells.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace proxima {

/// A rank's cells and all triangles that touch one of them. Triangles keep the order of the whole
/// mesh; vertices that came from different ranks are not joined.
struct RoutedPart {
    TriangleMesh mesh;
    std::vector<std::uint64_t> triangles; ///< triangle i's id in the whole mesh, ascending
    std::vector<bool> is_counted;         ///< of all ranks that have triangle i, one counts it
    std::vector<CellKey> keys;            ///< in Morton order
    std::vector<TriangleId> lists;        ///< of all cells, one after the other
    std::vector<std::size_t> first;       ///< key i has lists[first[i], first[i + 1])
    std::unique_ptr<RoutedForest> forest; ///< which rank owns which cells
};

struct RouteOptions {
    int max_depth = 5;
    std::uint32_t threshold = 1;
    /// The deepest level whose cells are shared out, at most 7. A less deep one is taken where
    /// triangles are so wide that their cells' numbers would be most of what is sent.
    int routing_depth = 5;
};

/// The deepest level that bins of triangles have.
inline constexpr int max_routing_depth = max_bin_depth;

/// Splits the root to the routing depth, shares its leaves and sends the triangles. Takes the slice.
/// Collective.
[[nodiscard]] Result<RoutedPart> route_triangles(MeshSlice slice, const OctreeFrame& frame,
                                                 const RouteOptions& options, World& world);

} // namespace proxima
