// Where the empty cells of a rank's part of an octree touch cells of other ranks.
#pragma once

#include "octree/empty_cells.h"
#include "octree/grow_part.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// Looks around in an octree of grow_part with CellsElsewhere::recorded. Refers to all of it.
class PartBorders {
public:
    PartBorders(const Octree& octree, const EmptyGroups& groups, const GrownPart& part);

    /// The group of the empty cell that is the given one or contains it; nothing where the part has
    /// none there. O(depth).
    [[nodiscard]] std::optional<std::uint32_t> empty_at(CellKey key) const noexcept;

    /// Calls visit(group, neighbour) for empty cells at sides where the part may end, with the cell
    /// of the same size beyond, which may or may not be the part's own. O(cells there).
    template <class Visit>
    void each_face(const Visit& visit) const
    {
        if (octree_.nodes().empty() || octree_.nodes()[0].is_leaf()) return;
        for (const Cell& cell : part_.cells) {
            for (std::uint32_t side = 0; side < 6; ++side) {
                const auto beyond = neighbour(cell.key, side);
                if (!beyond || is_own(*beyond)) continue;
                if (cell.node == Cell::no_node) {
                    visit(*empty_at(cell.key), *beyond);
                } else if (!octree_.is_leaf(cell)) {
                    visit_side(cell.node, cell.key, side, visit);
                }
            }
        }
    }

private:
    /// The cell of the same size beyond a side: below and above on x, y and z.
    [[nodiscard]] static std::optional<CellKey> neighbour(CellKey key, std::uint32_t side) noexcept;

    /// Whether the part has all of the cell.
    [[nodiscard]] bool is_own(CellKey key) const noexcept;

    template <class Visit>
    void visit_side(std::uint32_t record, CellKey key, std::uint32_t side, const Visit& visit) const
    {
        const EmptyGroups::Octants of = groups_.octants(record);
        for (std::uint32_t bits = detail::octants_at_side[side] & (of.empty | of.split); bits != 0;
             bits &= bits - 1) {
            const auto octant = static_cast<std::uint32_t>(std::countr_zero(bits));
            const CellKey below = child(key, static_cast<int>(octant));
            if ((of.empty >> octant & 1U) != 0) {
                visit(EmptyGroups::number(of, octant), *neighbour(below, side));
            } else {
                visit_side(record_of(record, octant), below, side, visit);
            }
        }
    }

    [[nodiscard]] std::uint32_t record_of(std::uint32_t parent, std::uint32_t octant) const noexcept
    {
        const OctreeNode node = octree_.nodes()[parent];
        return node.first + count_octants(node.recorded_mask() & ((1U << octant) - 1));
    }

    const Octree& octree_;
    const EmptyGroups& groups_;
    const GrownPart& part_;
    std::vector<std::uint32_t> cell_records_; ///< of cells with triangles, ascending
};

} // namespace proxima
