#include "proxima/octree.h"

#include "octree/list_figures.h"

#include <algorithm>

namespace proxima {

namespace {

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

    set_list_figures(counter.sum_of_squares, statistics);
    statistics.bytes = octree.bytes();
    return statistics;
}

} // namespace proxima
