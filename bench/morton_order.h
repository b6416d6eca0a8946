// Points sorted along a Morton curve, for peers whose neighbours in memory shall be near in space.
#pragma once

#include "proxima/geometry.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima::bench {

/// Indices of the points along the curve through a box, ties by index. Points outside are taken
/// for the nearest in the box. O(n log n).
[[nodiscard]] std::vector<std::uint32_t> morton_order(std::span<const Vec3> points, const Box& box);

} // namespace proxima::bench
