// Which of a cell's eight children each of many triangles touches, in vector lanes.
//
// Vertices lie on a grid of 2^30 steps per root edge. For a (triangle, cell) pair, p = (v - c) / h
// are the corners seen from the cell's centre c in units of its half size h. The Minkowski sum of
// triangle and child cube has 17 facets (thesis 3.4, in closed form): 6 box planes, 2 triangle
// planes, 9 edge planes; the child's centre lies in the sum iff triangle and child touch. All eight
// children follow from the parent's values by additions (index tracking, thesis 3.5).
//
//   stage 1  boxes and contained vertices, in exact integers: decides most pairs
//   stage 2  planes and edges, in floats, only for children that are still open
//   unsure   children within the rounding bound of stage 2: left to the caller
#pragma once

#include "base/grow_buffer.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// Steps of the snapping grid per root edge: 2^snapped_bits.
inline constexpr int snapped_bits = 30;

/// Elements that every array handed to the lanes must have beyond its count, readable.
inline constexpr std::size_t lane_padding = 64;

/// A point on the grid; the fourth number fills a vector register.
using SnappedPoint = std::array<std::int32_t, 4>;

/// A triangle on the grid, relative to some origin: what lanes load by three registers.
using SnappedTriangle = std::array<SnappedPoint, 3>;

/// What all cells of one depth share, and how far the grid may be off.
struct SnappedLevel {
    std::int32_t half = 0;   ///< half size of the (parent) cells, in grid steps, a power of two
    float error = 0;         ///< error of grid positions relative to cell planes, in half sizes
    std::int32_t margin = 1; ///< the same in grid steps, rounded up
};

/// (triangle, cell) pairs: index into an array of triangles, and the cell's centre in grid steps.
/// The triangle array's padding must hold valid indices (zeros).
/// Every triangle touches its cell.
struct SnappedPairs {
    const std::uint32_t* triangle = nullptr;
    std::array<const std::int32_t*, 3> center = {};
    std::size_t count = 0;
};

/// A pair whose children in `children` (bits) the lanes could not decide.
struct UnsurePair {
    std::uint32_t pair = 0;
    std::uint32_t children = 0;
};

/// Reused between calls so that levels do not allocate.
struct SnappedScratch {
    GrowBuffer<std::uint32_t> open_pairs;
    GrowBuffer<std::uint32_t> open_children;
    GrowBuffer<std::uint32_t> open_triangles;
    std::array<GrowBuffer<std::int32_t>, 3> open_centers;
    GrowBuffer<UnsurePair> unsure; ///< result, ascending by pair
};

/// Writes for every pair the mask of children that its triangle certainly touches (bit = octant)
/// to masks[pair] (pairs.count + lane_padding elements), and lists those that it might touch in
/// scratch.unsure; all others it certainly does not touch. Bits are the same on every instruction
/// set.
void find_touched_children(const SnappedTriangle* triangles, const SnappedLevel& level,
                           const SnappedPairs& pairs, SnappedScratch& scratch,
                           std::uint32_t* masks);

} // namespace proxima
