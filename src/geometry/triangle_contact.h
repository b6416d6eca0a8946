// Whether triangles and segments meet, exactly: by signs of orientation determinants alone.
#pragma once

#include "proxima/geometry.h"

namespace proxima {

/// Whether the closed segment from p to q and the closed triangle have a point in common. A
/// degenerate triangle is the segment or the point that it is, and so is p = q. Exact. \pre finite.
/// Thread safe, no allocation, 10 to 100 ns; microseconds in one plane.
[[nodiscard]] bool segment_meets_triangle(const Vec3& p, const Vec3& q,
                                          const Triangle& triangle) noexcept;

/// Whether two closed triangles have a point in common, degenerate ones as above
/// [guigue-2003]. Exact. \pre finite. Thread safe, no allocation, 10 to 200 ns;
/// microseconds in one plane, and where rounding could decide. intersect() of
/// triangle_intersection.h says where they meet.
[[nodiscard]] bool triangles_meet(const Triangle& a, const Triangle& b) noexcept;

} // namespace proxima
