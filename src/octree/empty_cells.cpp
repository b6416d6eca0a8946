#include "octree/empty_cells.h"

#include "base/fixed_stack.h"

namespace proxima {

std::uint32_t empty_octants(const Octree& octree, std::uint32_t record) noexcept
{
    const OctreeNode node = octree.nodes()[record];
    if (octree.parameters().subdivision == Subdivision::adaptive) {
        return ~node.recorded_mask() & 0xFFU;
    }
    std::uint32_t empty = 0;
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
        if (octree.nodes()[node.first + octant].is_empty()) empty |= 1U << octant;
    }
    return empty;
}

std::uint64_t count_empty_cells(const Octree& octree) noexcept
{
    std::uint64_t count = 0;
    for (std::uint32_t record = 0; record < octree.nodes().size(); ++record) {
        const OctreeNode node = octree.nodes()[record];
        if (node.is_leaf() || node.is_empty()) continue;
        count += count_octants(empty_octants(octree, record));
    }
    return count;
}

EmptyCells collect_empty_cells(const Octree& octree)
{
    struct Pending {
        std::uint32_t record = 0;
        CellKey key;
    };
    EmptyCells cells;
    cells.keys.reserve(count_empty_cells(octree));
    cells.first_of.resize(octree.nodes().size());
    FixedStack<Pending, 7 * max_octree_depth + 1> pending;
    if (!octree.nodes()[0].is_leaf()) pending.push({});
    while (!pending.empty()) {
        const Pending top = pending.pop();
        const OctreeNode node = octree.nodes()[top.record];
        const std::uint32_t empty = empty_octants(octree, top.record);
        cells.first_of[top.record] = static_cast<std::uint32_t>(cells.keys.size());
        for (int octant = 0; octant < 8; ++octant) {
            if ((empty >> static_cast<unsigned>(octant) & 1U) != 0) {
                cells.keys.push_back(child(top.key, octant));
            }
        }
        for (int octant = 7; octant >= 0; --octant) {
            const std::uint32_t bit = 1U << static_cast<unsigned>(octant);
            if ((node.recorded_mask() & ~empty & bit) == 0) continue;
            const std::uint32_t record =
                node.first + count_octants(node.recorded_mask() & (bit - 1));
            if (!octree.nodes()[record].is_leaf()) pending.push({record, child(top.key, octant)});
        }
    }
    return cells;
}

} // namespace proxima
