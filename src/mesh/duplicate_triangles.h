// Triangles of the same three vertices: which way they face, and which of them a surface can spare.
// Internal.
#pragma once

#include "proxima/execution.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima::detail {

/// Whether both run round their vertices the same way. \pre they have the same three, all different
[[nodiscard]] bool face_the_same_way(const TriangleCorners& a, const TriangleCorners& b) noexcept;

/// 1 for the triangles that are dropped as duplicates. `first` gives for each the first of the same
/// three vertices, itself for those that have none. Of each such set the first stays of those that
/// face the way of most.
///
/// Sets that face both ways, with at most one more triangle one way than the other, may be walls
/// between solids or folds: the first of each way stays, but not where that leaves edges open. Such
/// sets are decided together that meet at edges of no others. Those drop their second side that
/// have an odd number of triangles at all edges with others, else at most of them, in the order of
/// ids, again and again until that changes nothing. A component of nothing but such sets also drops
/// it, unless it has an edge of an odd number of sets from three on.
///
/// Linear, but for edges of many sets and for sets whose choices hang on each other in long chains;
/// topology is built if there are sets that face both ways. Errors: those of build_topology.
[[nodiscard]] Result<std::vector<std::uint8_t>>
redundant_triangles(std::span<const Vec3> positions, std::span<const TriangleCorners> triangles,
                    std::span<const std::uint32_t> first, const Execution& execution);

} // namespace proxima::detail
