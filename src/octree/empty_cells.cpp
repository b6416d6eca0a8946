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
        if (node.is_leaf() || node.is_empty()) continue;
        const std::uint32_t empty = empty_octants(octree, record);
        const std::uint32_t apart = alone.empty() ? 0U : alone[record];
        std::uint32_t split = 0;
        std::uint32_t child = node.first;
        for (std::uint32_t bits = node.recorded_mask(); bits != 0; bits &= bits - 1) {
            const std::uint32_t octant = bits & (~bits + 1U);
            split |= nodes[child++].is_leaf() ? 0U : octant;
        }
        // All that a cell may have, without a branch for each; as many count as it has.
        const std::uint32_t first = count();
        const detail::OctantGroups& together = detail::octant_groups[empty & ~apart];
        groups_.reserve(first + together.octants.size() + 8);
        EmptyGroup* end = groups_.data() + first;
        for (std::size_t i = 0; i < together.octants.size(); ++i) {
            end[i] = {CellKey{}, record, together.octants[i]};
        }
        end += together.count;
        for (std::uint32_t bits = apart; bits != 0; bits &= bits - 1) {
            *end++ = {CellKey{}, record, static_cast<std::uint8_t>(bits & (~bits + 1U)), true};
        }
        groups_.resize(static_cast<std::size_t>(end - groups_.data()));
        octants_[record] = {.first = first,
                            .groups = static_cast<std::uint8_t>(count() - first),
                            .empty = static_cast<std::uint8_t>(empty),
                            .split = static_cast<std::uint8_t>(split & ~empty),
                            .alone = static_cast<std::uint8_t>(apart)};
    }
}

} // namespace proxima
