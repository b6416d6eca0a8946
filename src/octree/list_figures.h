// Counts of an octree's leaves and lists, and what follows from them: percentages, means, deviations.
#pragma once

#include "proxima/octree.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace proxima {

__extension__ using WideUnsigned = unsigned __int128;

/// Standard deviation of `count` integers from their exact sums.
[[nodiscard]] inline double population_deviation(std::uint64_t count, std::uint64_t sum,
                                                 WideUnsigned sum_of_squares) noexcept
{
    if (count == 0) return 0.0;
    const WideUnsigned spread =
        count * sum_of_squares - WideUnsigned{sum} * sum; // count^2 variances
    return std::sqrt(static_cast<double>(spread)) / static_cast<double>(count);
}

[[nodiscard]] inline double ratio(std::uint64_t part, std::uint64_t whole) noexcept
{
    return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// Sets the figures that follow from statistics.leaves, occupied_leaves and references.
inline void set_list_figures(WideUnsigned sum_of_squares, OctreeStatistics& statistics) noexcept
{
    statistics.occupied_percent = 100.0 * ratio(statistics.occupied_leaves, statistics.leaves);
    statistics.mean_triangles = ratio(statistics.references, statistics.occupied_leaves);
    statistics.std_triangles =
        population_deviation(statistics.occupied_leaves, statistics.references, sum_of_squares);
    statistics.mean_all_leaves = ratio(statistics.references, statistics.leaves);
    statistics.std_all_leaves =
        population_deviation(statistics.leaves, statistics.references, sum_of_squares);
}

/// How many cells an octree has with so many leaves: every split cell has eight children.
[[nodiscard]] inline std::uint64_t cells_of_leaves(std::uint64_t leaves) noexcept
{
    return leaves + (leaves - 1) / 7;
}

/// Visits the leaves of an octree, or of a part of one, and counts them in `statistics`, but for the
/// figures that need all of them.
struct LeafCounter {
    OctreeStatistics statistics;
    std::uint64_t sum_of_squares = 0; ///< below 2^64: lists sum to at most 2^32

    static bool should_enter(const Cell&) noexcept { return true; }
    Flow visit_leaf(const Cell& cell, std::span<const TriangleId> triangles) noexcept
    {
        const int level = depth(cell.key);
        ++statistics.leaves;
        ++statistics.leaves_at_depth[static_cast<std::size_t>(level)];
        statistics.depth_reached = std::max(statistics.depth_reached, level);
        ++class_count(cell.type);
        if (triangles.empty()) return Flow::proceed;
        const auto count = static_cast<std::uint32_t>(triangles.size());
        statistics.min_triangles =
            statistics.occupied_leaves == 0 ? count : std::min(statistics.min_triangles, count);
        statistics.max_triangles = std::max(statistics.max_triangles, count);
        ++statistics.occupied_leaves;
        statistics.references += count;
        sum_of_squares += std::uint64_t{count} * count;
        return Flow::proceed;
    }

private:
    std::uint64_t& class_count(CellClass type) noexcept
    {
        switch (type) {
        case CellClass::inner:
            return statistics.inner;
        case CellClass::outer:
            return statistics.outer;
        case CellClass::boundary:
            return statistics.boundary;
        default:
            return statistics.unclassified;
        }
    }
};

} // namespace proxima
