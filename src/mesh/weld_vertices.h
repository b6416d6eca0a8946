// Giving every position one vertex: the shared vertices that formats without indices have lost.
#pragma once

#include "proxima/execution.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// Merges vertices whose coordinates are equal (0.0 == -0.0; NaNs of the same bits are equal too).
/// The first vertex of a position stays, in its place among the others, so ids go by first
/// appearance. Triangles keep order and number, also those that were degenerate before. Expected
/// O(vertices + triangles). False, with both arrays spoilt, where `progress` (stage "welding
/// vertices") asks to stop.
[[nodiscard]] bool weld_vertices(std::vector<Vec3>& positions,
                                 std::vector<TriangleCorners>& triangles,
                                 Progress* progress = nullptr);

/// Scratch that weld_vertices takes for so many vertices, in bytes.
[[nodiscard]] std::uint64_t weld_scratch_bytes(std::uint64_t vertex_count) noexcept;

} // namespace proxima
