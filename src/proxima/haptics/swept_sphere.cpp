#include "proxima/haptics/swept_sphere.h"

#include "proxima/geometry/exact_predicates.h"

#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// The first t at which |from + t motion| = radius, where that is in [0, 1]; never otherwise.
double entry_time(const Vec3& from, const Vec3& motion, double radius) noexcept
{
    const double speed_squared = motion.squaredNorm();
    if (!(speed_squared > 0)) return never;
    const double nearest = -from.dot(motion) / speed_squared;
    if (!(nearest > 0)) return never; // it moves away
    const Vec3 perpendicular = from + nearest * motion;
    const double left = radius * radius - perpendicular.squaredNorm();
    if (!(left > 0)) return never;
    const double t = nearest - std::sqrt(left / speed_squared);
    return t >= 0 && t <= 1 ? t : never;
}

/// Whether the product of two sides is right to some digits: little of it cancels.
bool is_plump(const Triangle& triangle, const Vec3& scaled) noexcept
{
    constexpr double plump = 0x1p-16;
    const double squared = scaled.squaredNorm();
    return squared > plump * (triangle[1] - triangle[0]).squaredNorm() *
                         (triangle[2] - triangle[0]).squaredNorm() &&
           squared > 1e-280;
}

bool is_above(const Triangle& triangle, const Vec3& normal, const Vec3& x) noexcept
{
    for (int k = 0; k < 3; ++k) {
        const Vec3& from = triangle[k];
        const Vec3 side = triangle[(k + 1) % 3] - from;
        if (!(side.cross(x - from).dot(normal) >= 0)) return false;
    }
    return true;
}

double side_time(const Vec3& from, const Vec3& to, double radius, const Vec3& p,
                 const Vec3& motion) noexcept
{
    const Vec3 side = to - from;
    const double length_squared = side.squaredNorm();
    if (!(length_squared > 0)) return never;
    const Vec3 at = p - from;
    const double start = at.dot(side) / length_squared;
    const double pace = motion.dot(side) / length_squared;
    const double t = entry_time(at - start * side, motion - pace * side, radius);
    if (t == never) return never;
    const double along = start + t * pace;
    return along >= 0 && along <= 1 ? t : never;
}

} // namespace

Vec3 unit_normal(const Triangle& triangle) noexcept
{
    const Vec3 scaled = scaled_normal(triangle);
    if (is_plump(triangle, scaled)) return scaled / scaled.norm();
    return unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
}

std::optional<double> touch_time(const Triangle& triangle, double radius, const Vec3& p,
                                 const Vec3& motion) noexcept
{
    const Vec3 scaled = scaled_normal(triangle);
    const double scaled_height = scaled.dot(p - triangle[0]);
    const double scaled_end = scaled_height + scaled.dot(motion);
    const double scaled_radius_squared =
        1.01 * radius * radius * scaled.squaredNorm(); // more than rounding of plump ones
    // Most triangles: the whole way on one side of the offset planes.
    if (scaled_height * scaled_end > 0 && is_plump(triangle, scaled) &&
        scaled_height * scaled_height > scaled_radius_squared &&
        scaled_end * scaled_end > scaled_radius_squared)
        return std::nullopt;

    // Outside of both planes, nothing else can be touched before them.
    const Vec3 normal = unit_normal(triangle);
    const double height = normal.dot(p - triangle[0]);
    const double rise = normal.dot(motion);
    if (std::abs(height) > radius) {
        const double towards = height > 0 ? -rise : rise;
        const double left = std::abs(height) - radius;
        if (!(towards >= left)) return std::nullopt;
        const double t = left / towards;
        if (is_above(triangle, normal, p + t * motion)) return t;
    }
    double first = never;
    for (int k = 0; k < 3; ++k) {
        const Vec3& corner = triangle[k];
        first = std::min(first, side_time(corner, triangle[(k + 1) % 3], radius, p, motion));
        first = std::min(first, entry_time(p - corner, motion, radius));
    }
    if (first == never) return std::nullopt;
    return first;
}

} // namespace proxima
