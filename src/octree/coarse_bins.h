// Sorts triangles into the cells of one coarse level, where most of them lie in one cell.
//
//     first   0    0    3    7 ...        one entry per cell in Morton order, and an end
//     ids     4 9 11 | 0 4 8 9 | ...      triangles that touch the cell, ascending
#pragma once

#include "octree/snapped_mesh.h"
#include "proxima/execution.h"
#include "proxima/result.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace proxima {

/// The deepest level of bins.
inline constexpr int max_bin_depth = 7;

/// Triangles per coarse cell.
struct CoarseBins {
    int depth = 0; ///< of the coarse cells; 8^depth of them
    std::vector<std::uint32_t> first;
    GrowBuffer<std::uint32_t> ids;

    [[nodiscard]] std::size_t cell_count() const noexcept { return first.size() - 1; }
    [[nodiscard]] std::uint32_t count(std::size_t cell) const noexcept
    {
        return first[cell + 1] - first[cell];
    }
    [[nodiscard]] std::span<const std::uint32_t> triangles(std::size_t cell) const noexcept
    {
        return ids.span().subspan(first[cell], count(cell));
    }
};

/// A good depth for the bins: a few dozen to a few hundred triangles a cell, cells no smaller than
/// most triangles, at most max_depth.
[[nodiscard]] int choose_bin_depth(const SnappedMesh& mesh, int max_depth);

/// Sums over triangles, in edges of the root: the widths of their boxes along all axes, and the areas
/// of their projections on the coordinate planes.
struct CoverageSum {
    double triangles = 0;
    double widths = 0;
    double areas = 0;

    /// Expected number of pairs of a triangle and a cell of that depth that touch, averaged over all
    /// shifts of the grid: the volumes of the triangles' Minkowski sums with a cell, in cells.
    [[nodiscard]] double pairs(int depth) const noexcept
    {
        const double cells = std::ldexp(1.0, depth);
        return triangles + cells * (widths + cells * areas);
    }
};

/// Estimated from every n-th triangle, about 2^16 of them. What pairs() then tells is within an eighth
/// of the pairs that bin_triangles finds of random triangles in the root from depth 3 on, and within a
/// half above (coarse_bins_test.cpp). The grid that bins use has one shift: a mesh whose faces lie in
/// planes between cells touches both sides of them, about twice as many cells.
[[nodiscard]] CoverageSum sum_coverage(const SnappedMesh& mesh);

/// Bins all triangles; the result does not depend on the threads. Not to be used once `progress` is
/// cancelled; two steps per triangle. Errors: limit_exceeded where there are more pairs of a triangle
/// and a cell than that, or more of triangles over more than two cells on an axis.
/// \pre 0 <= depth <= max_bin_depth, most_pairs < 2^32
[[nodiscard]] Result<CoarseBins>
bin_triangles(const SnappedMesh& mesh, int depth, Threads threads, Progress* progress,
              std::uint64_t most_pairs = std::numeric_limits<std::uint32_t>::max(),
              std::uint64_t most_wide_pairs = std::numeric_limits<std::uint32_t>::max());

/// Bins all triangles, as bin_triangles does, at the greatest depth up to `depth` at which bins and
/// scratch take at most `most_bytes`, not counting one id and one coverage for each triangle. At depth 0
/// they take no more than these. Errors and preconditions are those of bin_triangles.
[[nodiscard]] Result<CoarseBins> bin_triangles_within(std::uint64_t most_bytes,
                                                      const SnappedMesh& mesh, int depth,
                                                      Threads threads, Progress* progress);

} // namespace proxima
