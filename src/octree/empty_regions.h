// Empty cells that belong together: components, which faces connect, and regions, which caps of the
// mesh's holes part further (classify_cells.h).
#pragma once

#include "octree/empty_cells.h"
#include "proxima/octree.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace proxima {

/// Regions of empty cells: sets without a triangle between them; and components.
struct EmptyRegions {
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    std::vector<std::uint32_t> of_group; ///< none for groups that are alone: caps may touch them
    std::vector<CellKey> start;          ///< the largest cell of each region
    std::vector<std::uint32_t> component_of; ///< of each group; empty where no group is alone

    [[nodiscard]] std::uint32_t count() const noexcept
    {
        return static_cast<std::uint32_t>(start.size());
    }
    [[nodiscard]] std::uint32_t component(std::uint32_t group) const noexcept
    {
        return component_of.empty() ? of_group[group] : component_of[group];
    }
};

/// Tells the groups where they are, too. Both are numbered by their smallest groups. Useless once
/// `progress` is cancelled. `is_capped`: some groups may be alone.
[[nodiscard]] EmptyRegions find_regions(const Octree& octree, EmptyGroups& groups, bool is_capped,
                                        const Progress* progress);

} // namespace proxima
