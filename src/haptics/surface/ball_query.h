// A ball as the lanes of a triangle tree's search see it: in the tree's units, as floats, with more
// to spare than these round.
#pragma once

#include "index/triangle_tree.h"

#include <algorithm>
#include <cmath>

namespace proxima {

/// A ball in the tree's units.
struct BallQuery {
    float place[3];
    float squared; ///< of its radius
};

namespace detail {
/// Of the place, of the boxes and of their differences as floats, along three axes.
inline double ball_rounding(const Vec3& place) noexcept
{
    return 0x1p-21 * (2 + place.cwiseAbs().maxCoeff());
}
} // namespace detail

/// Every group with a triangle within `distance` of p has a box whose squared distance, as the
/// lanes compute it, is at most `squared`. \pre p is finite, distance >= 0
[[nodiscard]] inline BallQuery ball_query(const TriangleTree& tree, const Vec3& p,
                                          double distance) noexcept
{
    const Vec3 place = (p - tree.origin()) * tree.scale();
    BallQuery query{};
    for (int axis = 0; axis < 3; ++axis) query.place[axis] = static_cast<float>(place[axis]);
    const double radius = distance * tree.scale() * (1 + 0x1p-20) + detail::ball_rounding(place);
    query.squared = static_cast<float>(radius * radius * (1 + 0x1p-20));
    return query;
}

/// A distance, near the greatest, whose query's `squared` is no more than this, or 0 where there is
/// none.
[[nodiscard]] inline double ball_reach(const TriangleTree& tree, const Vec3& p,
                                       float squared) noexcept
{
    const Vec3 place = (p - tree.origin()) * tree.scale();
    const double radius = std::sqrt(std::max(0.0, static_cast<double>(squared))) * (1 - 0x1p-20);
    return std::max(0.0, (radius - detail::ball_rounding(place)) * (1 - 0x1p-19) / tree.scale());
}

} // namespace proxima
