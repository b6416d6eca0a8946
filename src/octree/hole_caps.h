// Imaginary triangles that close a mesh's holes, so that it winds a whole number of times round
// every point.
//
// An edge is balanced where as many triangles run along it one way as the other. The unbalanced
// ones form closed walks: the rims of holes, of flipped patches, of sheets. A fan from each rim's
// middle to its edges makes them balanced too.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// An edge and how many more triangles run from `from` to `to` than back. A triangle adds at most
/// one, so that the sums of all triangles fit.
struct DirectedEdge {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::int32_t excess = 0;
};

/// The fans; no triangles where the mesh is closed and consistently oriented. Vertices at equal
/// positions are one. With w the mesh's winding number and c that of the caps, w + c is a whole
/// number everywhere off both surfaces, and 0 outside the mesh's bounding box, which contains the
/// caps. O(triangles) time and scratch. Error cancelled by `progress`, stage "looking for holes".
/// \pre checked_bounding_box(mesh)
[[nodiscard]] Result<TriangleMesh> hole_caps(const TriangleMesh& mesh, Progress* progress);

// The two steps of hole_caps, for meshes that lie in parts.

/// The edges that are not balanced where vertices are told apart by their ids, by their lower
/// vertices, then by their higher ones; excess > 0.
[[nodiscard]] Result<std::vector<DirectedEdge>> unbalanced_edges(const TriangleMesh& mesh,
                                                                 Progress* progress);

/// The fans of hole_caps from the unbalanced edges of a whole mesh, in any order. The fans do not
/// depend on the vertices' ids but for their order.
[[nodiscard]] Result<TriangleMesh> cap_rims(std::vector<DirectedEdge> edges,
                                            std::span<const Vec3> positions, Progress* progress);

} // namespace proxima
