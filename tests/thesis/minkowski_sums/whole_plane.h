// Whole numbers of 128 bits for tests of planar sums, and sums that must be there.
#pragma once

#include "thesis/minkowski_sums/planar_sum.h"

#include <array>
#include <stdexcept>
#include <vector>

namespace proxima::testing {

using Points = std::vector<Vec2>;

__extension__ using Wide = __int128;
using Whole = std::array<Wide, 2>;

inline Whole whole(const Vec2& v)
{
    return {static_cast<Wide>(v.x()), static_cast<Wide>(v.y())};
}
inline Whole operator-(const Whole& a, const Whole& b)
{
    return {a[0] - b[0], a[1] - b[1]};
}
inline Whole operator+(const Whole& a, const Whole& b)
{
    return {a[0] + b[0], a[1] + b[1]};
}
inline Wide cross(const Whole& u, const Whole& v)
{
    return u[0] * v[1] - u[1] * v[0];
}
inline Wide dot(const Whole& u, const Whole& v)
{
    return u[0] * v[0] + u[1] * v[1];
}

inline ConvexPolygon polygon_of(const Points& points, const Points& rays = {})
{
    auto polygon = convex_polygon(points, rays);
    if (!polygon) throw std::runtime_error(describe(polygon.error()));
    return *polygon;
}

inline PlanarSum sum_of(const ConvexPolygon& a, const ConvexPolygon& b, double cut_length = 1)
{
    auto sum = planar_sum(a, b, {.cut_length = cut_length});
    if (!sum) throw std::runtime_error(describe(sum.error()));
    return *sum;
}

/// The exact sum of a pair of real corners.
inline Whole exact_point(const PlanarSum& sum, int k)
{
    const CornerPair pair = sum.pair(k);
    return whole(sum.a().corners[static_cast<std::size_t>(pair.a)]) +
           whole(sum.b().corners[static_cast<std::size_t>(pair.b)]);
}

} // namespace proxima::testing
