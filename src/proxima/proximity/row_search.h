// Searches all triangles: for points outside of the root.
#pragma once

#include "proxima/proximity/triangle_row.h"

#include <limits>
#include <span>

namespace proxima {

template <class Scalar>
[[nodiscard]] FeatureDistance search_all_rows(std::span<const TriangleRow<Scalar>> rows,
                                              const Vec3& p) noexcept
{
    FeatureDistance best;
    best.squared = std::numeric_limits<double>::infinity();
    for (std::uint32_t rank = 0; rank < rows.size(); ++rank) {
        const FeatureDistance found = closest_of_row(rows[rank], rank, p);
        if (found.before(best)) best = found;
    }
    return best;
}

} // namespace proxima
