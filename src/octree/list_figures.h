// What follows from the counts of an octree's leaves and lists: percentages, means, deviations.
#pragma once

#include "proxima/octree.h"

#include <cmath>
#include <cstdint>

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

} // namespace proxima
