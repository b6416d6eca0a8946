// The largest cells that no triangle touches, in groups of siblings, and which groups share a face.
//
//     +---+---+   A group: empty octants of one cell that faces between them connect. A cell has at
//     | a | # |   most four; this one, seen flat, has a and b, because triangles touch both #.
//     +---+---+
//     | # | b |   In an adaptive octree the empty cells are its empty leaves. In a uniform one a
//     +---+---+   split cell without triangles stands for all leaves below it.
#pragma once

#include "base/grow_buffer.h"
#include "base/progress.h"
#include "proxima/octree.h"

#include <array>
#include <bit>
#include <cstdint>
#include <span>

namespace proxima {

namespace detail {

/// Set bits of each mask of eight; a table, because not every machine of this instruction set has
/// an instruction for it.
inline constexpr auto octant_counts = [] {
    std::array<std::uint8_t, 256> table{};
    for (std::uint32_t bits = 0; bits < table.size(); ++bits) {
        for (std::uint32_t left = bits; left != 0; left &= left - 1) ++table[bits];
    }
    return table;
}();

/// How the octants of a mask fall into groups that faces connect, by their lowest octants.
struct OctantGroups {
    std::uint8_t count = 0;
    std::uint8_t sides = 0;                    ///< the cell's sides where the mask has octants
    std::array<std::uint8_t, 4> octants = {};  ///< a mask for each group
    std::array<std::uint8_t, 8> group_of = {}; ///< for each octant of the mask
};

/// Octants at each side of a cell: below and above on x, y and z.
inline constexpr std::array<std::uint32_t, 6> octants_at_side = {0x55, 0xAA, 0x33,
                                                                 0xCC, 0x0F, 0xF0};

inline constexpr auto octant_groups = [] {
    std::array<OctantGroups, 256> table{};
    for (std::uint32_t mask = 0; mask < table.size(); ++mask) {
        OctantGroups& groups = table[mask];
        for (std::size_t side = 0; side < 6; ++side) {
            if ((mask & octants_at_side[side]) != 0) groups.sides |= std::uint8_t(1U << side);
        }
        for (std::uint32_t left = mask; left != 0;) {
            std::uint32_t group = left & (~left + 1U);
            // A step reaches neighbours: no octant of eight is more than seven away.
            for (int step = 0; step < 7; ++step) {
                group |= ((group & 0x55U) << 1U) | ((group & 0xAAU) >> 1U) |
                         ((group & 0x33U) << 2U) | ((group & 0xCCU) >> 2U) |
                         ((group & 0x0FU) << 4U) | ((group & 0xF0U) >> 4U);
                group &= mask;
            }
            for (std::size_t octant = 0; octant < 8; ++octant) {
                if ((group >> octant & 1U) != 0) {
                    groups.group_of[octant] = static_cast<std::uint8_t>(groups.count);
                }
            }
            groups.octants[groups.count++] = static_cast<std::uint8_t>(group);
            left &= ~group;
        }
    }
    return table;
}();

} // namespace detail

/// Set bits of a mask of eight.
[[nodiscard]] inline std::uint32_t count_octants(std::uint32_t mask) noexcept
{
    return detail::octant_counts[mask & 0xFFU];
}

/// Octants of a split record that no triangle touches, as bits. \pre the record is split, not empty
[[nodiscard]] std::uint32_t empty_octants(const Octree& octree, std::uint32_t record) noexcept;

/// How many empty cells there are. O(nodes), no allocation.
[[nodiscard]] std::uint64_t count_empty_cells(const Octree& octree) noexcept;

/// Empty octants of one cell that faces between them connect.
struct EmptyGroup {
    CellKey parent;           ///< once EmptyFaces has been there
    std::uint32_t record = 0; ///< of the parent
    std::uint8_t octants = 0;
    bool is_alone = false;     ///< one octant, set apart on request
    bool at_root_face = false; ///< one of them lies at a face of the root; as parent

    /// The first of its cells, smallest by key.
    [[nodiscard]] CellKey first_cell() const noexcept
    {
        return child(parent, std::countr_zero(octants));
    }
};

/// Groups by number, in the order of the records of their parents.
class EmptyGroups {
public:
    /// What the octants of a split record with triangles are.
    struct Octants {
        std::uint32_t first = 0; ///< its first group; those of octants alone come last
        std::uint8_t groups = 0; ///< how many it has
        std::uint8_t empty = 0;  ///< octants without triangles
        std::uint8_t split = 0;  ///< octants that are split, with triangles
        std::uint8_t alone = 0;  ///< empty octants that are groups of their own
    };

    /// Octants in `alone`, a mask for each record, or none at all, are groups of their own. O(nodes).
    /// \pre count_empty_cells(octree) < 2^32, and all octants in `alone` are empty
    explicit EmptyGroups(const Octree& octree, std::span<const std::uint8_t> alone = {});

    [[nodiscard]] std::uint32_t count() const noexcept
    {
        return static_cast<std::uint32_t>(groups_.size());
    }
    [[nodiscard]] const EmptyGroup& operator[](std::uint32_t group) const noexcept
    {
        return groups_[group];
    }
    [[nodiscard]] EmptyGroup& operator[](std::uint32_t group) noexcept { return groups_[group]; }

    /// \pre the record is split, not empty
    [[nodiscard]] Octants octants(std::uint32_t record) const noexcept { return octants_[record]; }

    /// Group of an empty octant.
    [[nodiscard]] static std::uint32_t number(const Octants& of, std::uint32_t octant) noexcept
    {
        const detail::OctantGroups& together = detail::octant_groups[of.empty ^ of.alone];
        const std::uint32_t bit = 1U << octant;
        if ((of.alone & bit) != 0) {
            return of.first + together.count + count_octants(of.alone & (bit - 1));
        }
        return of.first + together.group_of[octant];
    }

private:
    GrowBuffer<Octants> octants_;
    GrowBuffer<EmptyGroup> groups_;
};

/// Descends an octree once: tells the groups where they are, and calls meet(a, b) for all pairs of
/// them that share part of a face, some more than once. Every cell knows its six neighbours of the
/// same size, or the larger leaf beside it. O(nodes).
template <class Meet>
class EmptyFaces {
public:
    EmptyFaces(const Octree& octree, EmptyGroups& groups, Meet& meet,
               const Progress* progress) noexcept
        : octree_(octree), groups_(groups), meet_(meet), progress_(progress)
    {}

    /// Not all of them once `progress` is cancelled.
    void visit_all()
    {
        if (octree_.nodes()[0].is_leaf()) return;
        Sides around;
        around.at_root_face = all_sides;
        visit_cell(0, CellKey{}, around);
        visit_children(0, CellKey{}, around);
    }

private:
    /// What lies at the sides of a cell, as bits of sides; leaves with triangles are in none.
    struct Sides {
        std::uint32_t empty = 0;
        std::uint32_t split = 0;
        std::uint32_t at_root_face = 0;
        std::array<std::uint32_t, 6> id = {}; ///< an empty cell's group, a split one's record
    };
    static constexpr std::uint32_t all_sides = 0x3F;
    static constexpr std::uint32_t lower_sides = 0x15;

    /// Tells what lies at a side: an octant of a split record.
    void set_side(Sides& sides, std::uint32_t side, std::uint32_t record,
                  const EmptyGroups::Octants& of, std::uint32_t octant) const noexcept
    {
        const bool is_empty = (of.empty >> octant & 1U) != 0;
        const std::uint32_t is_split = of.split >> octant & 1U;
        const OctreeNode node = octree_.nodes()[record];
        const std::uint32_t child =
            node.first + count_octants(node.recorded_mask() & ((1U << octant) - 1));
        sides.empty |= std::uint32_t{is_empty} << side;
        sides.split |= is_split << side;
        sides.id[side] = is_empty ? EmptyGroups::number(of, octant) : child;
    }

    /// The groups of one cell. Returns whether some of its octants are split.
    bool visit_cell(std::uint32_t record, CellKey key, const Sides& around)
    {
        const EmptyGroups::Octants own = groups_.octants(record);
        for (std::uint32_t i = 0; i < own.groups; ++i) groups_[own.first + i].parent = key;
        if (own.alone != 0) meet_within(own);
        meet_around(own, around);
        return own.split != 0;
    }

    void visit_children(std::uint32_t record, CellKey key, const Sides& around)
    {
        if (is_cancelled(progress_)) return;
        const EmptyGroups::Octants own = groups_.octants(record);
        const OctreeNode node = octree_.nodes()[record];
        for (std::uint32_t bits = own.split; bits != 0; bits &= bits - 1) {
            const auto octant = static_cast<std::uint32_t>(std::countr_zero(bits));
            Sides sides;
            for (std::uint32_t axis = 0; axis < 3; ++axis) {
                const std::uint32_t outer = 2 * axis + (octant >> axis & 1U);
                const std::uint32_t opposite = octant ^ 1U << axis;
                set_side(sides, outer ^ 1U, record, own, opposite);
                if ((around.split >> outer & 1U) != 0) {
                    const std::uint32_t beyond = around.id[outer];
                    set_side(sides, outer, beyond, groups_.octants(beyond), opposite);
                } else {
                    sides.empty |= around.empty & 1U << outer;
                    sides.at_root_face |= around.at_root_face & 1U << outer;
                    sides.id[outer] = around.id[outer];
                }
            }
            const std::uint32_t before = (1U << octant) - 1;
            const std::uint32_t below = node.first + count_octants(node.recorded_mask() & before);
            const CellKey key_below = child(key, static_cast<int>(octant));
            if (visit_cell(below, key_below, sides)) visit_children(below, key_below, sides);
        }
    }

    /// Faces within a cell at octants that are groups of their own.
    void meet_within(const EmptyGroups::Octants& own)
    {
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            const std::uint32_t step = 1U << axis;
            const std::uint32_t lower = detail::octants_at_side[std::size_t{2} * axis];
            std::uint32_t pairs = own.empty & lower & std::uint32_t{own.empty} >> step;
            for (; pairs != 0; pairs &= pairs - 1) {
                const auto octant = static_cast<std::uint32_t>(std::countr_zero(pairs));
                const std::uint32_t a = EmptyGroups::number(own, octant);
                const std::uint32_t b = EmptyGroups::number(own, octant | step);
                if (a != b) meet_(a, b);
            }
        }
    }

    /// A cell's groups, with what lies beyond its sides. A smaller cell there meets them when it is
    /// visited; of two cells of one size, only the upper one looks.
    void meet_around(const EmptyGroups::Octants& own, const Sides& around)
    {
        const std::uint32_t looks = around.split & lower_sides;
        std::uint32_t sides =
            detail::octant_groups[own.empty].sides & (around.empty | around.at_root_face | looks);
        for (; sides != 0; sides &= sides - 1) {
            const auto side = static_cast<std::uint32_t>(std::countr_zero(sides));
            for (std::uint32_t i = own.first; i < own.first + own.groups; ++i) {
                const std::uint32_t here = groups_[i].octants & detail::octants_at_side[side];
                if (here == 0) continue;
                if ((looks >> side & 1U) != 0) {
                    meet_split(i, here, side / 2, groups_.octants(around.id[side]));
                } else if ((around.empty >> side & 1U) != 0) {
                    meet_(around.id[side], i);
                } else {
                    groups_[i].at_root_face = true;
                }
            }
        }
    }

    /// A group's octants `here`, with those below on an axis.
    void meet_split(std::uint32_t group, std::uint32_t here, std::uint32_t axis,
                    const EmptyGroups::Octants& below)
    {
        for (std::uint32_t j = below.first; j < below.first + below.groups; ++j) {
            const std::uint32_t there = std::uint32_t{groups_[j].octants} >> (1U << axis);
            if ((here & there) != 0) meet_(j, group);
        }
    }

    const Octree& octree_;
    EmptyGroups& groups_;
    Meet& meet_;
    const Progress* progress_;
};

} // namespace proxima
