// Points sorted along a Morton curve, for peers whose neighbours in memory shall be near in space.
#pragma once

#include "proxima/geometry.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima::bench {

/// Bits of each coordinate that a batch of points is sorted by: two passes of the radix sort, as
/// in our own batches.
inline constexpr int batch_order_bits = 7;

/// The most bits of a coordinate that can be sorted by: three passes.
inline constexpr int most_order_bits = 10;

/// Indices of the points along the curve, by a radix sort; ties by index. The curve goes through a
/// cube 1.25 times as large as the box; points outside count as in its nearest cell.
/// \pre 0 < bits <= most_order_bits. O(n)
[[nodiscard]] std::vector<std::uint32_t> morton_order(std::span<const Vec3> points, const Box& box,
                                                      int bits);

/// Whether it pays to sort a batch: of 64 samples, most neighbours are in different cells of
/// batch_order_bits. The same test as in our own batches.
[[nodiscard]] bool pays_to_sort(std::span<const Vec3> points, const Box& box);

} // namespace proxima::bench
