// Which of the groups kept round a place a way may meet, and how soon: by their boxes alone.
//
//     met       by the slabs of a box, as wide as the distance
//     how soon  by these, and by a plane across the way to the box's middle: a large sphere that
//               goes along a surface has groups about it that it never comes to
#pragma once

#include "haptics/surface/triangle_groups.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// Groups that a way may meet, and before which part of it, 0 to 1, nothing of each is near.
struct GroupsAlongSegment {
    static constexpr std::size_t capacity =
        GroupBoxes::capacity + 16; ///< whole vectors are written
    std::size_t count = 0;
    std::array<std::uint32_t, capacity> ids = {};
    std::array<float, capacity> times = {};
};

/// The groups whose boxes are within the distance of the place, or of the way if there is one, and
/// some that are a little farther. 20 ns. \pre boxes.count <= GroupBoxes::capacity
void groups_along_segment(const GroupBoxes& boxes, const GroupQuery& query,
                          GroupsAlongSegment& near) noexcept;

} // namespace proxima
