#include "distributed/part_borders.h"

namespace proxima {

PartBorders::PartBorders(const Octree& octree, const EmptyGroups& groups, const GrownPart& part)
    : octree_(octree), groups_(groups), part_(part)
{
    for (const Cell& cell : part.cells) {
        if (cell.node != Cell::no_node) cell_records_.push_back(cell.node);
    }
    std::ranges::sort(cell_records_);
}

std::optional<std::uint32_t> PartBorders::empty_at(CellKey key) const noexcept
{
    if (octree_.nodes().empty() || octree_.nodes()[0].is_leaf()) return std::nullopt;
    std::uint32_t record = 0;
    for (int level = depth(key) - 1; level >= 0; --level) {
        const auto octant = static_cast<std::uint32_t>(key.bits >> (3 * level) & 7U);
        const EmptyGroups::Octants of = groups_.octants(record);
        if ((of.empty >> octant & 1U) != 0) return EmptyGroups::number(of, octant);
        if ((of.split >> octant & 1U) == 0) return std::nullopt;
        record = record_of(record, octant);
    }
    return std::nullopt;
}

bool PartBorders::is_own(CellKey key) const noexcept
{
    std::uint32_t record = 0;
    for (int level = depth(key) - 1; level >= 0; --level) {
        if (std::ranges::binary_search(cell_records_, record)) return true;
        const auto octant = static_cast<std::uint32_t>(key.bits >> (3 * level) & 7U);
        const EmptyGroups::Octants of = groups_.octants(record);
        if ((of.empty >> octant & 1U) != 0) return true;
        record = record_of(record, octant);
        if ((of.split >> octant & 1U) == 0) break;
    }
    return std::ranges::binary_search(cell_records_, record);
}

std::optional<CellKey> PartBorders::neighbour(CellKey key, std::uint32_t side) noexcept
{
    const int level = depth(key);
    const bool up = side % 2 != 0;
    std::array<std::uint32_t, 3> at = cell_coordinates(key);
    std::uint32_t& along = at[side / 2];
    if (along == (up ? (1U << static_cast<unsigned>(level)) - 1 : 0)) return std::nullopt;
    along += up ? 1U : ~0U;
    return cell_key(at, level);
}

} // namespace proxima
