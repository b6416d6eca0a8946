// The closest points of two triangles.
//
//     apart     a corner and a point of the other triangle, or a point of two sides: 6 + 9 cases
//     meeting   any point that they have in common
//
// Degenerate triangles count as the segments and points that they are. Whether triangles meet is
// decided exactly (triangle_intersection.h).
#pragma once

#include "geometry/closest_point.h"
#include "proxima/geometry.h"

#include <limits>

namespace proxima {

/// Two points, one on each of two triangles, and the square of their distance.
struct ClosestTrianglePoints {
    TrianglePoint first;
    TrianglePoint second;
    /// 0 if and only if the triangles meet: then both are one point.
    double squared_distance = std::numeric_limits<double>::infinity();
};

/// The closest points of two triangles; any where many are. Where the inside, a side or a corner
/// is as close as another, up to rounding, either may be named. The distance is off by a few
/// roundings of the largest difference of coordinates, and so are the points from the triangles.
/// Triangles that are apart by less than that have a tiny distance, never 0. \pre as for all of
/// closest_point.h. Thread safe, no allocation. 0.3 to 1.5 us.
[[nodiscard]] ClosestTrianglePoints closest_points(const Triangle& first,
                                                   const Triangle& second) noexcept;

} // namespace proxima
