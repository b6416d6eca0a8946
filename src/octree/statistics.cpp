#include "proxima/octree.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

__extension__ using WideUnsigned = unsigned __int128;

/// Standard deviation of `count` integers from their exact sums.
double population_deviation(std::uint64_t count, std::uint64_t sum, std::uint64_t sum_of_squares)
{
    if (count == 0) return 0.0;
    const WideUnsigned spread =
        WideUnsigned{count} * sum_of_squares - WideUnsigned{sum} * sum; // count^2 variances
    return std::sqrt(static_cast<double>(spread)) / static_cast<double>(count);
}

double ratio(std::uint64_t part, std::uint64_t whole)
{
    return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

struct Counter {
    OctreeStatistics& statistics;
    const Octree& octree;
    std::uint64_t sum_of_squares = 0; // below 2^64: lists sum to at most 2^32

    bool should_enter(const Cell& cell) const noexcept
    {
        ++statistics.total;
        if (!octree.is_leaf(cell)) return true;
        const int level = depth(cell.key);
        statistics.depth_reached = std::max(statistics.depth_reached, level);
        ++statistics.leaves_at_depth[static_cast<std::size_t>(level)];
        switch (cell.type) {
        case CellClass::inner:
            ++statistics.inner;
            break;
        case CellClass::outer:
            ++statistics.outer;
            break;
        case CellClass::boundary:
            ++statistics.boundary;
            break;
        case CellClass::unclassified:
            ++statistics.unclassified;
            break;
        }
        return true;
    }

    Flow visit_leaf(const Cell&, std::span<const TriangleId> triangles) noexcept
    {
        ++statistics.leaves;
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
};

} // namespace

OctreeStatistics octree_statistics(const Octree& octree) noexcept
{
    OctreeStatistics statistics;
    if (octree.nodes().empty()) return statistics;
    Counter counter{statistics, octree};
    traverse(octree, counter);

    statistics.occupied_percent = 100.0 * ratio(statistics.occupied_leaves, statistics.leaves);
    statistics.mean_triangles = ratio(statistics.references, statistics.occupied_leaves);
    statistics.std_triangles = population_deviation(statistics.occupied_leaves,
                                                    statistics.references, counter.sum_of_squares);
    statistics.mean_all_leaves = ratio(statistics.references, statistics.leaves);
    statistics.std_all_leaves =
        population_deviation(statistics.leaves, statistics.references, counter.sum_of_squares);
    statistics.bytes = octree.bytes();
    return statistics;
}

} // namespace proxima
