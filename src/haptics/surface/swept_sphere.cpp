#include "haptics/surface/swept_sphere.h"

#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"

#include <algorithm>
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
    if (!(t >= 0 && t <= 1)) return never;
    return t;
}

/// Whether the cross product of two sides has few cancelled digits.
bool is_well_shaped(const Triangle& triangle, double squared) noexcept
{
    constexpr double least_share = 0x1p-16;
    return squared > least_share * (triangle[1] - triangle[0]).squaredNorm() *
                         (triangle[2] - triangle[0]).squaredNorm() &&
           squared > 1e-280 && squared < 1e280;
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
    if (!(along >= 0 && along <= 1)) return never;
    return t;
}

/// A path of a sphere's centre and a triangle, looked at until `last` <= 1.
struct Passage {
    const Triangle& triangle;
    const Vec3& p;
    const Vec3& motion;
    double last;

    [[nodiscard]] double distance_at(double t) const noexcept
    {
        const Vec3 center = p + t * motion;
        return (center - closest_point(triangle, center).point).norm();
    }
};

/// Whether the path stays on one side of the plane, nowhere nearer to it than `least`.
bool stays_above(double height, double rise, double last, double least) noexcept
{
    const double end = height + last * rise;
    return (height > 0) == (end > 0) && std::abs(height) >= least && std::abs(end) >= least;
}

/// Whether all of the path that is no farther than `least` from the plane lies beyond one side of the
/// triangle by more than that.
bool passes_beside(const Passage& passage, const Vec3& normal, double height, double rise,
                   double least) noexcept
{
    double from = 0;
    double to = passage.last;
    if (rise != 0) {
        const double a = (-least - height) / rise;
        const double b = (least - height) / rise;
        from = std::clamp(std::min(a, b), from, to);
        to = std::clamp(std::max(a, b), from, to);
    }
    for (int k = 0; k < 3; ++k) {
        const Vec3& corner = passage.triangle[k];
        const Vec3 side = passage.triangle[(k + 1) % 3] - corner;
        const Vec3 outward = side.cross(normal);
        const double start = outward.dot(passage.p - corner);
        const double pace = outward.dot(passage.motion);
        if (std::min(start + from * pace, start + to * pace) > least * side.norm()) return true;
    }
    return false;
}

/// A time at which the centre is nearest to the triangle. Its distance is a convex function of time.
double nearest_time(const Passage& passage, double height, double rise) noexcept
{
    double best = passage.last;
    double least = passage.distance_at(best);
    const auto offer = [&](double t) {
        if (!(t >= 0 && t < passage.last)) return;
        const double distance = passage.distance_at(t);
        if (!(distance < least)) return;
        least = distance;
        best = t;
    };
    offer(-height / rise); // no number where it does not rise
    const Segment path{passage.p, passage.p + passage.last * passage.motion};
    for (int k = 0; k < 3; ++k) {
        const Segment side{passage.triangle[k], passage.triangle[(k + 1) % 3]};
        offer(passage.last * closest_points(path, side).first.t);
    }
    return best;
}

/// The last time before `near` at which the centre is no nearer than `least`. \pre at 0 it is not
double last_free_time(const Passage& passage, double near, double least) noexcept
{
    constexpr int halvings = 40;
    double free = 0;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (free + near);
        (passage.distance_at(middle) >= least ? free : near) = middle;
    }
    return free;
}

} // namespace

Vec3 unit_normal(const Triangle& triangle) noexcept
{
    return TrianglePlane(triangle).normal();
}

TrianglePlane::TrianglePlane(const Triangle& triangle) noexcept
    : triangle_(triangle), scaled_((triangle[1] - triangle[0]).cross(triangle[2] - triangle[0])),
      squared_(scaled_.squaredNorm()), is_well_shaped_(is_well_shaped(triangle, squared_))
{}

bool TrianglePlane::is_beyond(const Vec3& p, const Vec3& motion, double distance) const noexcept
{
    const Vec3 from = p - triangle_[0];
    const double start = scaled_.dot(from);
    const double end = start + scaled_.dot(motion);
    if (!is_well_shaped_ || !(start * end > 0)) return false;
    // The error of a well-shaped triangle's normal is less than 2^-42.
    const double apart = distance + 0x1p-39 * (from.cwiseAbs().sum() + motion.cwiseAbs().sum());
    const double least = apart * apart * squared_ * (1 + 0x1p-40);
    return start * start > least && end * end > least;
}

Vec3 TrianglePlane::normal() const noexcept
{
    if (is_well_shaped_) return scaled_ / std::sqrt(squared_);
    return unit_normal({triangle_[0], triangle_[1]}, {triangle_[0], triangle_[2]});
}

double least_touch_time(const Triangle& triangle, double distance, const Vec3& p,
                        const Vec3& motion) noexcept
{
    const Vec3 a = triangle[0] - p;
    const Vec3 b = triangle[1] - p;
    const Vec3 c = triangle[2] - p;
    const Vec3 axis = a + b + c;
    const double sizes =
        a.cwiseAbs().sum() + b.cwiseAbs().sum() + c.cwiseAbs().sum() + motion.cwiseAbs().sum();
    const double nearest = std::min({axis.dot(a), axis.dot(b), axis.dot(c)});
    const double left = nearest - distance * axis.norm() * (1 + 0x1p-40) - 0x1p-46 * sizes * sizes;
    if (!(left > 0)) return 0;
    const double swept = axis.dot(motion) + 0x1p-46 * sizes * sizes;
    return swept > 0 ? left / swept * (1 - 0x1p-40) : never;
}

std::optional<double> touch_time(const Triangle& triangle, double radius, const Vec3& p,
                                 const Vec3& motion, double tolerance) noexcept
{
    const TrianglePlane plane(triangle);
    // For most triangles the whole path is on one side of the offset planes.
    if (plane.is_beyond(p, motion, radius)) return std::nullopt;

    // From outside of both planes, nothing is touched before one of them.
    const Vec3 normal = plane.normal();
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
    // At a grazing angle the place where the plane is met is off by rounding over that angle, more
    // than the face may begin beyond a side that is not touched either. So look whether the centre
    // comes too near until then.
    const Passage passage{triangle, p, motion, first == never ? 1.0 : first};
    const auto found = first == never ? std::nullopt : std::optional(first);
    if (stays_above(height, rise, passage.last, radius - 0.5 * tolerance)) return found;
    if (!found && passes_beside(passage, normal, height, rise, radius + tolerance)) return found;
    const double least = std::min(radius, passage.distance_at(0)) - tolerance;
    if (found && passage.distance_at(first) >= least) return found;
    const double near = nearest_time(passage, height, rise);
    if (passage.distance_at(near) >= least) return found;
    return last_free_time(passage, near, least + 0.5 * tolerance);
}

} // namespace proxima
