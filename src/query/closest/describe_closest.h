// Turns what a search found into the answer in full.
#pragma once

#include "index/index_parts.h"
#include "index/triangle_row.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"

namespace proxima {

/// no_closest_feature() where nothing was found. Else the answer named by the lowest triangle that
/// has the feature. Two loads that may miss the caches: where the feature is, and the row again.
[[nodiscard]] ClosestFeature describe_closest(const IndexParts& index,
                                              const RowDistance& found) noexcept;

/// The lowest triangle of what was found. \pre something was
[[nodiscard]] TriangleId triangle_of(const IndexParts& index, const RowDistance& found) noexcept;

/// The units of distances of rows.
[[nodiscard]] inline RowScale row_scale_of(const IndexParts& index) noexcept
{
    return {index.scale(), index.unscale()};
}

} // namespace proxima
