// Turns what a search found into the answer in full.
#pragma once

#include "index/mesh_index.h"
#include "index/triangle_row.h"
#include "query/closest/closest_feature.h"

namespace proxima {

/// no_closest_feature() where nothing was found. Else the answer named by the lowest triangle that
/// has the feature. Two loads that may miss the caches: the feature's place, and the row again.
[[nodiscard]] ClosestFeature describe_closest(const MeshIndex& index,
                                              const RowDistance& found) noexcept;

/// The lowest triangle of what was found. \pre something was
[[nodiscard]] TriangleId triangle_of(const MeshIndex& index, const RowDistance& found) noexcept;

/// The units of distances of rows.
[[nodiscard]] inline RowScale row_scale_of(const MeshIndex& index) noexcept
{
    return {index.scale(), index.unscale()};
}

} // namespace proxima
