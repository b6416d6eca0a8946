// Incremental convex hull of a few points: the baseline that the thesis sets its geometric method
// against (thesis 3.3.2).
//
//     tetrahedron of four points that are not coplanar; then for every other point:
//     visible faces -> their outline (the shadow boundary) -> replaced by a cone to the point
//
// Erratum of the thesis: the visibility products of 20 points are 4 + 6 + ... + 42 = 460, not 440,
// so 3,140 flops, not 3,040.
#pragma once

#include "minkowski/scalar_vector.h"

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// A triangle of the hull, counter-clockwise seen from outside; the hull has normal . x <= offset.
template <class Scalar>
struct HullFace {
    std::array<int, 3> vertices{};
    Vector3<Scalar> normal; ///< outward, twice the triangle's area long
    Scalar offset;
    Scalar visible_above; ///< offset plus what rounding may add: points beyond see the face
};

/// The faces of the convex hull of the points; a facet with more than three corners is several
/// coplanar faces. Points that rounding cannot tell from lying in a face's plane are not outside
/// it. Nothing when all points are coplanar, or when rounding broke the outline of the visible
/// faces (possible with needles near the resolution of doubles; never with small integers).
/// Instantiated for double and Counted; cost quadratic in the points.
template <class Scalar>
[[nodiscard]] std::optional<std::vector<HullFace<Scalar>>>
incremental_hull(std::span<const Vector3<Scalar>> points);

} // namespace proxima
