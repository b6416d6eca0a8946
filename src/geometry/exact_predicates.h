// Exact signs of orientation determinants of points with double coordinates.
//
//     double filter -> expansion arithmetic -> whole numbers of up to 12,800 bits
//
// The filter answers nearly always; expansions (expansion.h, [shewchuk-1997]) answer the rest where
// every coordinate is zero or between 2^-288 and 2^300 in size; outside of that range whole numbers
// (wide_integer.h) do, slowly. So the answers are exact for all finite doubles.
#pragma once

#include "geometry/scaled_number.h"
#include "proxima/geometry.h"

namespace proxima {

/// Sign of (b - a) x (c - a): +1 if a, b, c turn left, -1 right, 0 collinear. Exact.
/// \pre all finite. Cost: about 5 ns, 0.2 us where the filter fails. Thread safe, no allocation.
[[nodiscard]] int orient2d(const Vec2& a, const Vec2& b, const Vec2& c) noexcept;

/// Sign of ((b - a) x (c - a)) . (d - a): +1 if d lies on the side to which the triangle's normal
/// points (a, b, c counter-clockwise seen from d), -1 on the other, 0 coplanar. Exact.
/// \pre all finite. Cost: about 10 ns, 1 us where the filter fails. Thread safe, no allocation.
[[nodiscard]] int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) noexcept;

/// Sign of the determinant (u x v) . w: +1 if the three turn like the axes, -1 mirrored, 0 if they
/// lie in a plane. Exact. \pre all finite. Cost as orient3d's.
[[nodiscard]] int determinant_sign(const Displacement& u, const Displacement& v,
                                   const Displacement& w) noexcept;

/// The determinant (u x v) . w itself: exact in sign and within a few roundings in size, however
/// much cancels. Its exponent is 0 where every coordinate is zero or between 2^-288 and 2^300 in
/// size. \pre all finite. About 1 us; tens where coordinates differ by more than that in size.
[[nodiscard]] ScaledNumber exact_determinant(const Displacement& u, const Displacement& v,
                                             const Displacement& w) noexcept;

/// How far a point is from a sum of two, the second one scaled: point - a - scale b, exactly.
struct SumDisplacement {
    Vec3 point;
    Vec3 a;
    Vec3 b;
    double scale = 1;

    [[nodiscard]] Vec3 rounded() const noexcept { return point - a - scale * b; }
};

/// Sign of the determinant (u x v) . w of such a w. Exact. \pre all finite. Cost as orient3d's,
/// some microseconds where the filter fails.
[[nodiscard]] int determinant_sign(const Displacement& u, const Displacement& v,
                                   const SumDisplacement& w) noexcept;

/// Sign of the component of u x w along an axis, of such a w. Exact. \pre all finite
[[nodiscard]] int cross_component_sign(const Displacement& u, const SumDisplacement& w,
                                       int axis) noexcept;

/// Sign of the component of u x v along an axis. Exact. \pre all finite, axis in [0, 3).
/// Cost as orient2d's.
[[nodiscard]] int cross_component_sign(const Displacement& u, const Displacement& v,
                                       int axis) noexcept;

/// The direction of u x v, of length 1, each component within a few roundings of the length even
/// where the product nearly cancels; zero if they are parallel. \pre all finite
[[nodiscard]] Vec3 unit_normal(const Displacement& u, const Displacement& v) noexcept;

/// Whether one is a multiple of the other: u x v = 0. Exact. \pre all finite.
[[nodiscard]] bool are_parallel(const Displacement& u, const Displacement& v) noexcept;

/// Whether two displacements point the same way; true where one is none. \pre they are parallel
[[nodiscard]] bool point_same_way(const Displacement& u, const Displacement& v) noexcept;

/// Whether the triangle has no area: its corners are on one line, or in one point. Exact.
/// \pre all finite.
[[nodiscard]] bool is_degenerate(const Triangle& triangle) noexcept;

} // namespace proxima
