#include "octree/empty_cells.h"

#include <algorithm>

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
    const auto nodes = octree.nodes();
    if (octree.parameters().subdivision == Subdivision::adaptive) {
        // Eight cells below each split one, of which those without triangles have no record.
        const auto split =
            std::ranges::count_if(nodes, [](const OctreeNode& node) { return !node.is_leaf(); });
        return nodes.empty() ? 0 : 8 * static_cast<std::uint64_t>(split) + 1 - nodes.size();
    }
    std::uint64_t count = 0;
    for (std::uint32_t record = 0; record < nodes.size(); ++record) {
        if (nodes[record].is_leaf() || nodes[record].is_empty()) continue;
        count += count_octants(empty_octants(octree, record));
    }
    return count;
}

EmptyGroups::EmptyGroups(const Octree& octree, std::span<const std::uint8_t> alone)
{
    const auto nodes = octree.nodes();
    octants_.resize(nodes.size());
    for (std::uint32_t record = 0; record < nodes.size(); ++record) {
        const OctreeNode node = nodes[record];
        Octants of{.first = count(), .groups = 0, .empty = 0, .split = 0, .alone = 0};
        if (!node.is_leaf() && !node.is_empty()) {
            of.empty = static_cast<std::uint8_t>(empty_octants(octree, record));
            of.alone = alone.empty() ? std::uint8_t{0} : alone[record];
            std::uint32_t split = 0;
            std::uint32_t child = node.first;
            for (std::uint32_t bits = node.recorded_mask(); bits != 0; bits &= bits - 1) {
                if (!nodes[child++].is_leaf()) split |= bits & (~bits + 1U);
            }
            of.split = static_cast<std::uint8_t>(split & ~std::uint32_t{of.empty});
            const detail::OctantGroups& together = detail::octant_groups[of.empty ^ of.alone];
            for (std::uint32_t i = 0; i < together.count; ++i) {
                groups_.push_back({CellKey{}, record, together.octants[i]});
            }
            for (std::uint32_t bits = of.alone; bits != 0; bits &= bits - 1) {
                const auto octant = static_cast<std::uint8_t>(bits & (~bits + 1U));
                groups_.push_back({CellKey{}, record, octant, true});
            }
            of.groups = static_cast<std::uint8_t>(count() - of.first);
        }
        octants_[record] = of;
    }
}

} // namespace proxima
