// Which vertices are so near each other that they become one. Internal.
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// Scratch and result of near_vertices for so many vertices, in bytes.
[[nodiscard]] std::uint64_t near_vertices_bytes(std::uint64_t vertex_count) noexcept;

/// For every vertex of `takes_part` the one that it becomes: in ascending order, the nearest within
/// `distance` of those kept before (the lowest of several), or itself, which is then kept. Others
/// become themselves. Expected O(vertices): as many kept vertices as fit into a few cells without
/// being within `distance` of each other are compared with each. Nothing where `progress`, which
/// may be null, asks to stop. \pre those that take part are finite, 0 < distance <= 1e300
[[nodiscard]] std::optional<std::vector<std::uint32_t>>
near_vertices(std::span<const Vec3> positions, std::span<const std::uint8_t> takes_part,
              double distance, Progress* progress);

} // namespace proxima
