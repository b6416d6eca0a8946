// Finds which groups near a position a moving ball may meet, and how soon, by their boxes alone.
//
//     whether   by the slabs of each box, widened by the ball's radius
//     how soon  by these slabs, and by a plane across the direction to the box's middle: a large
//               sphere that slides along a surface never reaches many of the groups around it
//
// The input is the boxes that find_groups.h wrote for a ball: one ball serves many motions.
#pragma once

#include "haptics/surface/triangle_groups.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// Groups that a motion may meet, and the part of it, 0 to 1, before which it meets none of each.
struct GroupsAlongSegment {
    static constexpr std::size_t capacity =
        GroupBoxes::capacity + 16; ///< whole vectors are written
    std::size_t count = 0;
    std::array<std::uint32_t, capacity> ids = {};
    std::array<float, capacity> times = {};
};

/// Finds the groups whose boxes are within the query's distance of its position, or of its motion
/// if there is one, and some that are a little farther. 20 ns.
/// \pre boxes.count <= GroupBoxes::capacity
void groups_along_segment(const GroupBoxes& boxes, const GroupQuery& query,
                          GroupsAlongSegment& near) noexcept;

} // namespace proxima
