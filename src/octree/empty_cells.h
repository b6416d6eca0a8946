// The largest cells that no triangle touches, and which of them share a face.
//
// In an adaptive octree these are its empty leaves; in a uniform one a split cell without triangles
// stands for all leaves below it, so that both kinds are classified alike.
#pragma once

#include "base/progress.h"
#include "proxima/octree.h"

#include <array>
#include <cstdint>
#include <vector>

namespace proxima {

/// Set bits of eight; a table, because not every machine of this instruction set has one for it.
[[nodiscard]] inline std::uint32_t count_octants(std::uint32_t mask) noexcept
{
    static constexpr auto counts = [] {
        std::array<std::uint8_t, 256> table{};
        for (std::uint32_t bits = 0; bits < table.size(); ++bits) {
            for (std::uint32_t left = bits; left != 0; left &= left - 1) ++table[bits];
        }
        return table;
    }();
    return counts[mask & 0xFFU];
}

/// Octants of a split record that no triangle touches, as bits. \pre the record is split, not empty
[[nodiscard]] std::uint32_t empty_octants(const Octree& octree, std::uint32_t record) noexcept;

/// Empty cells by number, near ones close together.
struct EmptyCells {
    std::vector<CellKey> keys;           ///< address of each
    std::vector<std::uint32_t> first_of; ///< number of each split record's first empty octant

    /// Number of an empty octant. \pre mask == empty_octants(octree, record), contains octant
    [[nodiscard]] std::uint32_t number(std::uint32_t record, std::uint32_t mask,
                                       int octant) const noexcept
    {
        const std::uint32_t before = (1U << static_cast<unsigned>(octant)) - 1;
        return first_of[record] + count_octants(mask & before);
    }
};

/// How many there are. O(nodes), no allocation.
[[nodiscard]] std::uint64_t count_empty_cells(const Octree& octree) noexcept;

/// Numbers all empty cells. \pre count_empty_cells(octree) < 2^32. O(nodes).
[[nodiscard]] EmptyCells collect_empty_cells(const Octree& octree);

/// Calls meet(a, b) for every pair of empty cells that share part of a face, once each: descends
/// cells and faces together (Ju, Losasso, Schaefer and Warren 2002), O(nodes).
template <class Meet>
class EmptyFaces {
public:
    EmptyFaces(const Octree& octree, const EmptyCells& cells, Meet& meet,
               const Progress* progress) noexcept
        : octree_(octree), cells_(cells), meet_(meet), progress_(progress)
    {}

    /// Not all of them once `progress` is cancelled.
    void visit_all()
    {
        if (!octree_.nodes()[0].is_leaf()) visit_cell(0);
    }

private:
    enum class Kind : std::uint8_t { empty, occupied_leaf, split };

    /// One cell of a face: an empty cell's number or a record.
    struct Side {
        Kind kind = Kind::occupied_leaf;
        std::uint32_t id = 0;
    };

    [[nodiscard]] Side side(std::uint32_t record, std::uint32_t empty, int octant) const noexcept
    {
        const std::uint32_t bit = 1U << static_cast<unsigned>(octant);
        if ((empty & bit) != 0) return {Kind::empty, cells_.number(record, empty, octant)};
        const OctreeNode node = octree_.nodes()[record];
        const std::uint32_t child = node.first + count_octants(node.recorded_mask() & (bit - 1));
        return {octree_.nodes()[child].is_leaf() ? Kind::occupied_leaf : Kind::split, child};
    }

    void visit_cell(std::uint32_t record)
    {
        if (is_cancelled(progress_)) return;
        const std::uint32_t empty = empty_octants(octree_, record);
        std::array<Side, 8> sides;
        for (int octant = 0; octant < 8; ++octant) {
            sides[static_cast<std::size_t>(octant)] = side(record, empty, octant);
        }
        for (std::size_t axis = 1; axis < 8; axis *= 2) {
            for (std::size_t octant = 0; octant < 8; ++octant) {
                if ((octant & axis) == 0) visit_face(sides[octant], sides[octant | axis], axis);
            }
        }
        for (const Side& child : sides) {
            if (child.kind == Kind::split) visit_cell(child.id);
        }
    }

    /// The face between `low` and `high`, its upper neighbour on the axis of the octant bit.
    void visit_face(const Side& low, const Side& high, std::size_t axis)
    {
        if (low.kind == Kind::occupied_leaf || high.kind == Kind::occupied_leaf) return;
        if (low.kind == Kind::empty && high.kind == Kind::empty) {
            meet_(low.id, high.id);
            return;
        }
        const std::uint32_t low_empty =
            low.kind == Kind::split ? empty_octants(octree_, low.id) : 0;
        const std::uint32_t high_empty =
            high.kind == Kind::split ? empty_octants(octree_, high.id) : 0;
        for (std::size_t octant = 0; octant < 8; ++octant) {
            if ((octant & axis) != 0) continue;
            visit_face(
                low.kind == Kind::split ? side(low.id, low_empty, static_cast<int>(octant | axis))
                                        : low,
                high.kind == Kind::split ? side(high.id, high_empty, static_cast<int>(octant))
                                         : high,
                axis);
        }
    }

    const Octree& octree_;
    const EmptyCells& cells_;
    Meet& meet_;
    const Progress* progress_;
};

} // namespace proxima
