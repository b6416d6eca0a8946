// Regions and components of empty cells across the borders of ranks, joined on the first rank.
#pragma once

#include "distributed/world.h"
#include "proxima/octree.h"

#include <algorithm>
#include <compare>
#include <cstdint>
#include <vector>

namespace proxima {

/// The winding number of one region of the whole octree is that of another one plus a difference.
/// Regions count through all ranks from 1; 0 is the outside.
struct RegionTie {
    std::uint64_t region = 0;
    std::uint64_t from = 0;
    std::int64_t difference = 0;
    friend auto operator<=>(const RegionTie&, const RegionTie&) = default;
};

/// For each of this rank's regions that a tie names, once and ascending: the smallest one that ties
/// join it to. Regions of rank 0 come first, then those of rank 1, and so on. Collective.
[[nodiscard]] Result<std::vector<RegionTie>> join_regions(std::vector<RegionTie> ties,
                                                          std::uint64_t own_regions, World& world);

/// Components a and b, which count through all ranks from 0, are one.
struct ComponentMeeting {
    std::uint64_t a = 0;
    std::uint64_t b = 0;
    friend auto operator<=>(const ComponentMeeting&, const ComponentMeeting&) = default;
};

/// What a component has, or a part of one.
struct ComponentPart {
    std::uint64_t component = 0;
    std::uint64_t leaves = 0;
    std::uint32_t has_inner = 0; ///< 0 or 1
    std::uint32_t has_outer = 0; ///< 0 or 1; cells at the root's faces count

    void add(const ComponentPart& part) noexcept
    {
        leaves += part.leaves;
        has_inner |= part.has_inner;
        has_outer |= part.has_outer;
    }
};

/// Adds a whole component.
void count_component(const ComponentPart& whole, ClassificationSummary& summary) noexcept;

/// The summary of all components, on all ranks: of those that lie in one rank, `own` has this
/// rank's; `parts` has this rank's parts of the others. Collective.
[[nodiscard]] Result<ClassificationSummary> join_components(std::vector<ComponentMeeting> meetings,
                                                            std::vector<ComponentPart> parts,
                                                            const ClassificationSummary& own,
                                                            World& world);

/// Removes repeats.
template <class T>
void make_unique(std::vector<T>& items)
{
    std::sort(items.begin(), items.end());
    items.erase(std::unique(items.begin(), items.end()), items.end());
}

} // namespace proxima
