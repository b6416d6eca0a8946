// The time at which a moving sphere first touches a triangle: faces, sides and corners are offset
// to planes, cylinders and spheres.
//
//     the centre goes   p + t motion,  0 <= t <= 1
//     it touches        where the centre is `radius` from the triangle: a convex set, entered once
//
// A radius of a billionth of the coordinates still works: distances of lines are computed as lengths
// of perpendiculars, not as differences of squares.
#pragma once

#include "geometry/exact_predicates.h"
#include "proxima/geometry.h"

#include <optional>

namespace proxima {

/// The direction of the triangle's normal, of length 1, accurate to a few roundings for slivers
/// too; zero for a triangle without an area. 10 ns.
[[nodiscard]] Vec3 unit_normal(const Triangle& triangle) noexcept;

/// The plane of a triangle, which must outlive this. 5 ns.
class TrianglePlane {
public:
    explicit TrianglePlane(const Triangle& triangle) noexcept;

    /// True only if p and p + motion are on one side of it, both farther than the distance by more
    /// than the rounding of their heights. False for slivers.
    [[nodiscard]] bool is_beyond(const Vec3& p, const Vec3& motion, double distance) const noexcept;

    /// Like unit_normal().
    [[nodiscard]] Vec3 normal() const noexcept;

private:
    const Triangle& triangle_;
    Vec3 scaled_;
    double squared_;
    bool is_well_shaped_;
};

/// A time t of the path p + t motion before which no point of the triangle is within the distance.
/// It follows from the plane across the direction from p to the triangle's middle and includes
/// rounding. 0 if that plane decides nothing, infinity if the triangle is never within the
/// distance. This is a filter for large spheres; for points the planes of triangles are one. 5 ns.
[[nodiscard]] double least_touch_time(const Triangle& triangle, double distance, const Vec3& p,
                                      const Vec3& motion) noexcept;

/// The first t at which the sphere touches, or nothing. Until then, or until the end of the motion,
/// the centre comes no nearer than the radius or the distance at t = 0, whichever is less, but for
/// the tolerance. So it passes no triangle, whatever is rounded. noexcept, no allocation, 5 to 50 ns,
/// some microseconds where rounding leaves it in doubt.
/// \pre radius > tolerance; the tolerance is more than the rounding of coordinates, some 2^-46 of them
[[nodiscard]] std::optional<double> touch_time(const Triangle& triangle, double radius,
                                               const Vec3& p, const Vec3& motion,
                                               double tolerance) noexcept;

} // namespace proxima
