// The leaves of an octree that a camera sees (thesis section 5.4).
//
//     visible_cells(*octree, *volume, CullMode::conservative, [&](const VisibleCell& at) { ... });
//
// A plane that has a cell wholly inside is not asked again below it: subtrees inside of all planes
// are visited without a test.
#pragma once

#include "proxima/octree.h"
#include "proxima/view_volume.h"
#include "query/culling/cull_volume.h"

#include <type_traits>
#include <vector>

namespace proxima {

/// A leaf, empty or not.
struct VisibleCell {
    Cell cell;
    bool is_inside = false; ///< of all planes, wholly
};

namespace detail {
using VisitVisibleCell = Flow (*)(void* context, const VisibleCell& cell) noexcept;
void visible_cells(const Octree& octree, const ViewVolume& volume, CullMode mode,
                   VisitVisibleCell visit, void* context) noexcept;
} // namespace detail

/// Visits every visible leaf in Morton order: conservatively those that no single plane has on its
/// outside, exactly those whose closed box has a point in common with the volume. Both decided
/// exactly. `visitor(const VisibleCell&)` may return Flow to end the walk; it must not throw. About
/// 20 ns a cell, 50 where planes are asked, up to 5 us for undecided leaves in exact mode. Thread
/// safe, no allocation.
template <class Visitor>
void visible_cells(const Octree& octree, const ViewVolume& volume, CullMode mode,
                   Visitor&& visitor) noexcept
{
    auto adapted = [&](const VisibleCell& cell) noexcept -> Flow {
        if constexpr (std::is_same_v<std::invoke_result_t<Visitor&, const VisibleCell&>, Flow>) {
            return visitor(cell);
        } else {
            visitor(cell);
            return Flow::proceed;
        }
    };
    detail::visible_cells(
        octree, volume, mode,
        [](void* context, const VisibleCell& cell) noexcept -> Flow {
            return (*static_cast<decltype(adapted)*>(context))(cell);
        },
        &adapted);
}

/// The same as a list. Allocates it.
[[nodiscard]] std::vector<VisibleCell> visible_cells(const Octree& octree, const ViewVolume& volume,
                                                     CullMode mode = CullMode::conservative);

} // namespace proxima
