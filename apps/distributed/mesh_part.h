// A rank's part of a mesh for queries: the triangles whose middles lie in its cells, with an index
// of them and the names that they have in the whole.
//
//     p4est's cells, in Morton order     0 0 0 | 1 1 1 1 | 2 2     compact parts, as many triangles each
//
// Every triangle is in one part. Local ids ascend as those of the whole do, so that ties between a
// part's features go as they go in the whole mesh.
#pragma once

#include "distributed/feature_numbers.h"
#include "distributed/mesh_slice.h"
#include "distributed/world.h"
#include "octree/winding_number.h"
#include "proxima/mesh_index.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// All numbers of what an answer names have 64 bits.
struct MeshPart {
    MeshIndex index; ///< in the frame of the whole; of nothing where it is empty
    std::vector<std::uint64_t> triangles; ///< by local id, their ids in the whole
    std::vector<WholeFeature> vertices;
    std::vector<WholeFeature> edges;
    std::vector<Box> boxes; ///< of all ranks' parts; empty ones where they have no triangle
    Box whole_box;
    double scale = 1; ///< of the frame: a power of two
    std::uint64_t whole_triangles = 0;
    std::uint64_t unbalanced_edges = 0; ///< of the whole, see SliceFeatures
    WindingStorage winding; ///< of this rank's triangles, in rows of the index; see PartOptions

    [[nodiscard]] bool is_closed() const noexcept { return unbalanced_edges == 0; }
};

struct PartOptions {
    int routing_depth = 5;            ///< cells that are shared out have no deeper level
    bool has_winding_if_open = false; ///< whether winding numbers are made where the mesh is open
};

/// Shares the triangles out by their cells, and builds the index of this rank's. Takes the slice.
/// Collective.
[[nodiscard]] Result<MeshPart> make_mesh_part(MeshSlice slice, const PartOptions& options,
                                              World& world);

} // namespace proxima
