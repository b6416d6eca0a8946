// Turns what a search found into the answer in full.
#pragma once

#include "index/lists/proximity_octree.h"
#include "index/triangle_row.h"
#include "query/closest/closest_feature.h"

namespace proxima {

/// no_closest_feature() where nothing was found. Else the answer named by the lowest triangle that
/// has the feature. Two loads that may miss the caches: the feature's place, and the row again.
[[nodiscard]] ClosestFeature describe_closest(const ProximityOctree& octree,
                                              const RowDistance& found) noexcept;

} // namespace proxima
