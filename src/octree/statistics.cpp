#include "proxima/octree.h"

#include "octree/list_figures.h"

namespace proxima {

OctreeStatistics octree_statistics(const Octree& octree) noexcept
{
    LeafCounter counter;
    if (octree.nodes().empty()) return counter.statistics;
    traverse(octree, counter);
    OctreeStatistics statistics = counter.statistics;
    statistics.total = cells_of_leaves(statistics.leaves);
    set_list_figures(counter.sum_of_squares, statistics);
    statistics.bytes = octree.bytes();
    return statistics;
}

} // namespace proxima
