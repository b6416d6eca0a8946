// Finds the groups of triangles that a ball meets, by the boxes of a triangle tree.
//
//     level by level    the boxes of all blocks that the ball meets, eight at a time, in floats
//     prefetched        a block of the next level as soon as its box is met
//
// Nothing is sorted and there are no callbacks, because the slowest ticks are those in which
// contact_cache.h makes a new ball. visit_near.h visits in doubles and nearest first, with a
// callback that may end the search.
#pragma once

#include "haptics/surface/triangle_groups.h"
#include "haptics/surface/triangle_tree.h"

namespace proxima {

/// Finds the boxes of all groups that have a triangle within `distance` of p, and of some that are
/// a little farther. Of more than GroupBoxes::capacity, or a few less, some are missing, and
/// boxes.count is more than the capacity. noexcept, no allocation, 0.3 us. \pre p is finite,
/// distance >= 0
void find_groups(const TriangleTree& tree, const Vec3& p, double distance,
                 GroupBoxes& boxes) noexcept;

} // namespace proxima
