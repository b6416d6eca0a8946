// Whether triangles and segments meet, exactly: by signs of orientation determinants alone.
#pragma once

#include "proxima/geometry/shapes.h"
#include "proxima/geometry/vec.h"

namespace proxima {

/// Whether the closed segment from p to q and the closed triangle have a point in common. Exact.
/// \pre finite, p != q, the triangle has an area. Thread safe, no allocation, 10 to 100 ns.
[[nodiscard]] bool segment_meets_triangle(const Vec3& p, const Vec3& q,
                                          const Triangle& triangle) noexcept;

/// Whether two closed triangles have a point in common. Exact. \pre finite, both have an area.
/// Thread safe, no allocation, 50 to 500 ns.
[[nodiscard]] bool triangles_meet(const Triangle& a, const Triangle& b) noexcept;

} // namespace proxima
