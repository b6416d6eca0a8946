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
/// three vertices, itself for those that have none. One of each set stays: the first of those that
/// face the way of most. Where as many face one way as the other, they may be the two sides of a
/// wall between solids or of a fold. So of such sets that hang together across edges, one of each
/// side stays unless one triangle alone leaves fewer edges open where they meet the rest of the
/// surface, or there is no such edge. Linear; topology is built only if there are such sets.
/// Errors: those of build_topology.
[[nodiscard]] Result<std::vector<std::uint8_t>>
redundant_triangles(std::span<const Vec3> positions, std::span<const TriangleCorners> triangles,
                    std::span<const std::uint32_t> first, const Execution& execution);

} // namespace proxima::detail
