// A triangle whose corners move during a tick, each straight, and a sphere that moves meanwhile.
//
//     before       now             at time t, 0 <= t <= 1, a corner is at before + t (now - before)
//       /\          ___
//      /__\   ->    \ /            the sphere's centre at p + t motion
//                    v
//
// Both keep apart for the whole motion if they do so along one direction at its beginning and at its
// end: seen along a direction, each corner moves evenly past the centre. Times of contact and planes
// follow from this alone, so that triangles may turn and stretch by any amount.
#pragma once

#include "haptics/surface/contact_triangle.h"
#include "proxima/geometry.h"

#include <array>
#include <optional>

namespace proxima {

/// The sum of a triangle's corners times weights.
[[nodiscard]] inline Vec3 point_at(const Triangle& triangle,
                                   const std::array<double, 3>& weights) noexcept
{
    return weights[0] * triangle[0] + weights[1] * triangle[1] + weights[2] * triangle[2];
}

struct MovingTriangle {
    Triangle before;
    Triangle now;
    TriangleId id{};

    [[nodiscard]] Triangle at(double t) const noexcept;
};

/// The distance of p from the triangle along a direction of length 1, which is at most the distance.
[[nodiscard]] double separation(const Triangle& triangle, const Vec3& p,
                                const Vec3& direction) noexcept;

/// The direction, of length 1, along which p is separated most; zero for a triangle that is a point
/// at p. It differs from that away from the closest point where p is so near that rounding tilts it.
/// 0.2 us.
[[nodiscard]] Vec3 separating_direction(const Triangle& triangle, const Vec3& p) noexcept;

/// A time before which the sphere comes no deeper into the triangle than by `tolerance`: where it is
/// half as deep or more, or where 64 steps ended. Nothing where it comes no deeper at all, as where it
/// slides past. noexcept, no allocation, 0.2 us for each step. \pre at t = 0 the centre is farther than the radius; radius > 0, tolerance > 0
[[nodiscard]] std::optional<double> touch_time(const MovingTriangle& triangle, double radius,
                                               const Vec3& p, const Vec3& motion,
                                               double tolerance) noexcept;

/// A plane that separates a centre from the moving triangle.
struct MovingPlane {
    Vec3 normal = Vec3::UnitZ();
    Vec3 point =
        Vec3::Zero(); ///< of the triangle after the motion: nothing of it is beyond the plane
};

/// The plane of the contact at time t of the motion. A centre that ends where
/// normal . (x - point) >= radius keeps at least half the radius away all the time. Nothing where no
/// plane does so. \pre at t = 0 the centre is not nearer than the radius, up to rounding
[[nodiscard]] std::optional<MovingPlane> separating_plane(const MovingTriangle& triangle,
                                                          double radius, const Vec3& p,
                                                          const Vec3& motion, double t) noexcept;

} // namespace proxima
