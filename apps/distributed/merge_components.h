// Components of empty cells across the borders of ranks, joined on the first rank.
#pragma once

#include "distributed/world.h"
#include "proxima/octree.h"

#include <compare>
#include <cstdint>
#include <vector>

namespace proxima {

/// Components a and b, which count through all ranks from 0, are one.
struct ComponentMeeting {
    std::uint64_t a = 0;
    std::uint64_t b = 0;
    // NOLINTNEXTLINE(modernize-use-nullptr): no pointer is compared
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

} // namespace proxima
