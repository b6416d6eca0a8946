// A ball for the lanes that search a triangle tree: in the tree's units, as floats, larger by more
// than their rounding.
#pragma once

#include "haptics/surface/triangle_tree.h"

#include <algorithm>
#include <cmath>

namespace proxima {

/// A ball in the tree's units.
struct BallQuery {
    float position[3];
    float squared; ///< of its radius
};

namespace detail {
/// Bounds the rounding of position, boxes and their differences as floats, along three axes.
inline double ball_rounding(const Vec3& position) noexcept
{
    return 0x1p-21 * (2 + position.cwiseAbs().maxCoeff());
}
} // namespace detail

/// Every group with a triangle within `distance` of p has a box whose squared distance, as the
/// lanes compute it, is at most `squared`. \pre p is finite, distance >= 0
[[nodiscard]] inline BallQuery ball_query(const TriangleTree& tree, const Vec3& p,
                                          double distance) noexcept
{
    const Vec3 position = (p - tree.origin()) * tree.scale();
    BallQuery query{};
    for (int axis = 0; axis < 3; ++axis) query.position[axis] = static_cast<float>(position[axis]);
    const double radius = distance * tree.scale() * (1 + 0x1p-20) + detail::ball_rounding(position);
    query.squared = static_cast<float>(radius * radius * (1 + 0x1p-20));
    return query;
}

/// A distance, near the greatest one, whose query has no larger `squared`; 0 where there is none.
[[nodiscard]] inline double ball_reach(const TriangleTree& tree, const Vec3& p,
                                       float squared) noexcept
{
    const Vec3 position = (p - tree.origin()) * tree.scale();
    const double radius = std::sqrt(std::max(0.0, static_cast<double>(squared))) * (1 - 0x1p-20);
    return std::max(0.0, (radius - detail::ball_rounding(position)) * (1 - 0x1p-19) / tree.scale());
}

} // namespace proxima
