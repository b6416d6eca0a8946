// What lies at the same position under different ids: vertices, triangles, seams. Internal.
#pragma once

#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima::detail {

/// Key and hash of a triangle by its vertex ids in any order.
[[nodiscard]] TriangleCorners sorted_corners(TriangleCorners corners) noexcept;
[[nodiscard]] std::uint64_t hash_of(const TriangleCorners& sorted) noexcept;

/// For every vertex the first one at exactly its position (0 is -0), itself for non-finite ones.
[[nodiscard]] std::vector<std::uint32_t> first_at_position(const TriangleMesh& mesh);

/// For every triangle the first one whose corners have the same three different positions, in any
/// order; itself where two corners share one. Only pairs with at least one differing vertex id
/// need to be found. `same_position` is first_at_position(mesh).
[[nodiscard]] std::vector<std::uint32_t>
first_coincident(const TriangleMesh& mesh, std::span<const std::uint32_t> same_position);

/// Whether every edge would have an even number of triangles if vertices at one position were one
/// and triangles without three different corners were none. Errors: those of build_topology.
[[nodiscard]] Result<bool> is_closed_if_welded(const TriangleMesh& mesh,
                                               std::span<const std::uint32_t> same_position,
                                               const TopologyOptions& options);

} // namespace proxima::detail
