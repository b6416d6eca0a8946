// The closest features of all points of a regular grid, block by block.
//
//     32 points a side   the leaves of the index that may be closest to one of them, by the distance
//                        of their middle and their reach
//     16, 8              of these leaves those that may be closest to a part
//     8, 4, 2            of the leaves' triangles those that may be: the least of n (x - v) over the
//                        corners v bounds the distance of f from below, at x in the part. Eight
//                        parts look for what is closest to their middles together
//     64 points          these triangles, one after the other for eight points at once, in floats;
//                        what may be the closest then in doubles, as every search of the index does
//                        (closest/search_index-inl.h)
#pragma once

#include "index/index_parts.h"
#include "index/triangle_row.h"
#include "proxima/distance_field.h"
#include "proxima/execution.h"
#include "proxima/function_ref.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace proxima {

/// Points of a grid, a box of them.
struct GridBlock {
    std::array<std::uint32_t, 3> first{};
    std::array<std::uint32_t, 3> size{};
};

/// Points along each side of the blocks that a search begins with.
inline constexpr std::uint32_t grid_block_side = 32;

struct GridAnswers {
    GridBlock block;
    /// By point, x fastest; what is beyond the band may be found or not. Empty where all points of
    /// the block are beyond it.
    std::span<const RowDistance> found;
    /// No point of the surface is in the block, nor within rounding of it.
    bool is_clear = false;
    std::optional<bool> inside; ///< where all points of the block are, if that is known
};

/// A ball that the surface does not enter.
struct ClearBall {
    Vec3 middle = Vec3::Zero();
    double radius = 0;
    double distance = 0; ///< the middle is no nearer to the surface
};

/// What a search of a grid is asked.
struct GridQuestion {
    double band;         ///< nothing farther is searched for
    bool are_sides_dear; ///< whether small blocks are worth it whose side is known
    /// Whether all of a ball is inside, or outside; nothing where that is not known.
    FunctionRef<std::optional<bool>(const ClearBall&)> side_of;
    FunctionRef<void(const GridAnswers&)> take;
    Progress* progress; ///< may be null; where it asks to stop, answers from then on are worthless
};

/// How far any coordinate of the grid's points or of the mesh is from 0, at most, in the mesh's unit of
/// length.
[[nodiscard]] double largest_coordinate(const IndexParts& index, const PointGrid& grid) noexcept;

/// Searches for the closest features of a block's points and hands them over in pieces, each point
/// once. \pre the grid's points are finite, the block is in the grid
/// and no side is longer than grid_block_side
void search_grid(const IndexParts& index, const PointGrid& grid, const GridBlock& block,
                 const GridQuestion& question);

} // namespace proxima
