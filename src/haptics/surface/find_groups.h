// Which groups of triangles a ball meets, by the boxes of a triangle tree.
//
//     level by level    the boxes of all blocks that the ball meets, eight at a time, in floats
//     prefetched        a block of the next level as soon as its box is met
//
// Nothing is sorted and nothing called back: what a new ball of contact_cache.h costs is the tail
// of a tick's times.
#pragma once

#include "haptics/surface/triangle_groups.h"
#include "index/triangle_tree.h"

namespace proxima {

/// The boxes of all groups that have a triangle within `distance` of p, and of some that are a
/// little farther. Where more are met than there is about room for, boxes.count is more than
/// GroupBoxes::capacity and some are missing. noexcept, no allocation, 0.3 us. \pre p is finite,
/// distance >= 0
void find_groups(const TriangleTree& tree, const Vec3& p, double distance,
                 GroupBoxes& boxes) noexcept;

} // namespace proxima
