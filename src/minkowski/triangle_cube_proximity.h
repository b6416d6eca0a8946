// How deep a triangle is in a box, how to free it, or how far away it is (thesis 3.1, 3.6.4).
//
//     overlapping   penetration          the least motion that frees the triangle: over the at most
//                                        17 half-spaces of the sum of both, the one whose plane is
//                                        nearest to the box's centre
//                   penetration_along    the same along a given direction
//     apart         separation           the closest points
//
// A half-space's depth is what the triangle must move against the outward normal until its farthest
// corner leaves the box's farthest corner behind: a plane between the two then proves them apart.
// For that the normal need not be the sum's to the last bit. So whatever is returned does free the
// triangle, and rounding costs at most a little of its being the least.
//
// Units are those of the coordinates. Sizes do not matter: all is scaled by a power of two first.
// Triangles may be segments or points, boxes flat. Whether they overlap is decided exactly
// (triangle_box.h), touching included. No allocation, any thread.
#pragma once

#include "proxima/geometry.h"

#include <optional>

namespace proxima {

/// Moving the triangle by depth * direction leaves it touching the box.
struct Penetration {
    double depth = 0;              ///< >= 0; 0 if it only touches
    Vec3 direction = Vec3::Zero(); ///< of length 1
};

/// The least motion that frees the triangle from the box; none if they are apart already. The depth
/// is at most 1e-14 of the size S (of the largest coordinate difference of triangle and box
/// together) off that of a motion which frees it exactly. It is as near to the least one unless the
/// triangle is a needle: of width w and length L its normal is uncertain by 1e-16 L / w, and the
/// depth by no more than w and no more than that times S. Of several directions the first in the
/// order of triangle_cube_sum.h. About 0.6 us.
/// \pre all finite, box.lower <= box.upper
[[nodiscard]] std::optional<Penetration> penetration(const Triangle& triangle,
                                                     const Box& box) noexcept;

/// How far the triangle must move along the direction, of any length but 0, until it only touches
/// the box; none if they are apart already. Accurate as `penetration`, divided by the cosine
/// between the direction and the normal of the facet through which it leaves. About 0.6 us.
/// \pre all finite, box.lower <= box.upper, direction not zero
[[nodiscard]] std::optional<double> penetration_along(const Triangle& triangle, const Box& box,
                                                      const Vec3& direction) noexcept;

/// The closest points of a triangle and a box; one common point if they overlap.
struct TriangleBoxSeparation {
    double distance = 0; ///< exactly 0 if they overlap
    Vec3 on_triangle = Vec3::Zero();
    Vec3 on_box = Vec3::Zero();
};

/// The distance is right to 1e-14 of the size S, and so is where the points are: on triangle and
/// box, a distance apart. Some of many where there are many. 0.2 to 3 us.
/// \pre all finite, box.lower <= box.upper
[[nodiscard]] TriangleBoxSeparation separation(const Triangle& triangle, const Box& box) noexcept;

} // namespace proxima
