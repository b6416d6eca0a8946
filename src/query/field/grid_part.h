// The state of a grid search: parts of the grid, and what may be closest to them.
#pragma once

#include "index/index_parts.h"
#include "index/triangle_row.h"
#include "proxima/distance_field.h"
#include "proxima/geometry.h"
#include "query/field/grid_candidates.h"
#include "query/field/search_grid.h"

#include <array>
#include <optional>
#include <vector>

namespace proxima {

/// The state of a grid search: what it was asked, and memory that it uses again.
struct GridSearch {
    const IndexParts& index;
    const PointGrid& grid;
    const GridQuestion& question;
    std::array<LeafBoxes, 3> leaves;           ///< by level: of blocks of 32 points a side, 16, 8
    std::array<TriangleLanes, 3> triangles;    ///< of blocks of 8, 4, 2
    std::vector<std::array<float, 8>> squared; ///< by triangle, then eights of points
    std::vector<Vec3> points;
    std::vector<RowDistance> found;
};

/// A block and what is known of it. Lengths are in the mesh's unit.
struct GridPart {
    GridBlock block;
    Box box; ///< of its points
    Vec3 middle;
    double radius; ///< no point is farther from the middle
    /// A lower bound of the middle's distance; exact, but for rounding, for parts of 8 points a side and more.
    double least;
    std::optional<bool> inside; ///< where all points are, if that is known
};

inline GridPart part_of(const PointGrid& grid, const GridBlock& block,
                        const std::optional<bool>& inside) noexcept
{
    const auto [i, j, k] = block.first;
    const Box box{grid.point(i, j, k),
                  grid.point(i + block.size[0] - 1, j + block.size[1] - 1, k + block.size[2] - 1)};
    return {block, box, box.center(), 0.5 * box.extent().norm() * (1 + 0x1p-40), 0, inside};
}

} // namespace proxima
