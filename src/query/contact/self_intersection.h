// Where a mesh intersects itself: pairs of its triangles that meet in more than what they share.
//
//     no corner in common      they meet
//     one                      they meet elsewhere, too
//     two                      they lie in one plane, on the same side of their common edge
//     three                    always: one covers the other
//
// Corners at one position are common, whatever their ids: seams do not count. Exact, by
// triangle_intersection.h, and found through the mesh index of the mesh.
#pragma once

#include "index/mesh_index.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "query/contact/intersect_meshes.h"

#include <cstddef>
#include <vector>

namespace proxima {

/// Whether two triangles have a point in common that is neither a corner of both nor on a side that
/// joins two such corners; true of two that cover each other. A degenerate triangle is the segment
/// or point that it is. \pre finite. No allocation, thread safe; 0.1 to 1 us.
[[nodiscard]] bool meet_beyond_corners(const Triangle& a, const Triangle& b) noexcept;

struct SelfIntersectionOptions {
    std::size_t max_pairs = 1'000'000; ///< stops where more were found
    Execution execution = {};          ///< stage "finding self-intersections", steps are triangles
};

struct SelfIntersections {
    std::vector<TrianglePair> pairs; ///< a < b in each; by a, then b
    bool complete = true;            ///< false: there are more, these are max_pairs of them
};

/// All such pairs of the index's mesh. The same for any number of threads. Error cancelled. About
/// 5 us per triangle of a scanned model; quadratic where many triangles lie in one place.
[[nodiscard]] Result<SelfIntersections>
find_self_intersections(const MeshIndex& index, const SelfIntersectionOptions& options = {});

} // namespace proxima
