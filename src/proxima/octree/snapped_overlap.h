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

#include "proxima/base/grow_buffer.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// Steps of the snapping grid per root edge: 2^snapped_bits.
inline constexpr int snapped_bits = 30;

/// Elements that every array handed to the lanes must have beyond its count, readable.
inline constexpr std::size_t lane_padding = 64;

/// Triangles on the grid, relative to some origin: coordinate[3 * corner + axis][triangle].
struct SnappedTriangles {
    std::array<GrowBuffer<std::int32_t>, 9> coordinate;

    /// Room for `count` triangles and the lane padding, which is zeroed.
    void resize(std::size_t count);
};

/// A mesh on the grid, as lanes gather from it: four numbers a vertex, three corners a triangle.
struct SnappedArrays {
    const std::int32_t* vertices = nullptr;
    const std::uint32_t* corners = nullptr;

    // Lanes address both by signed 32-bit offsets.
    static constexpr std::size_t max_vertices = (std::size_t{1} << 31U) / 4;
    static constexpr std::size_t max_triangles = (std::size_t{1} << 31U) / 3;
};

/// Sets triangles[i] to mesh triangle ids[i], relative to `origin`, for i in [0, count).
/// \pre triangles.resize(count) was called, ids are padded with valid ones
void load_triangles(const SnappedArrays& mesh, const std::uint32_t* ids, std::size_t count,
                    const std::array<std::int32_t, 3>& origin, SnappedTriangles& triangles);

/// The inclusive range of cells at `depth` (7 at most) that the boxes of triangles [first, first +
/// count), grown by `margin` steps, touch: x | y << 8 | z << 16 of the lowest and the highest cell.
/// Both arrays have lane_padding elements to spare.
void find_cells_of_boxes(const SnappedArrays& mesh, std::size_t first, std::size_t count,
                         int depth, std::int32_t margin, std::uint32_t* lowest,
                         std::uint32_t* highest);

/// What all cells of one depth share, and how far the grid may be off.
struct SnappedLevel {
    std::int32_t half = 0;   ///< half size of the (parent) cells, in grid steps, a power of two
    float error = 0;         ///< error of grid positions relative to cell planes, in half sizes
    std::int32_t margin = 1; ///< the same in grid steps, rounded up
};

/// (triangle, cell) pairs: index into SnappedTriangles, and the cell's centre in grid steps. The
/// triangle array's padding must hold valid indices (zeros).
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
    GrowBuffer<UnsurePair> unsure; ///< result, ascending by pair
};

/// Writes for every pair the mask of children that its triangle certainly touches (bit = octant)
/// to masks[pair] (pairs.count + lane_padding elements), and lists those that it might touch in
/// scratch.unsure; all others it certainly does not touch. Bits are the same on every instruction
/// set.
void find_touched_children(const SnappedTriangles& triangles, const SnappedLevel& level,
                           const SnappedPairs& pairs, SnappedScratch& scratch,
                           std::uint32_t* masks);

} // namespace proxima
