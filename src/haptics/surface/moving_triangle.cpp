#include "haptics/surface/moving_triangle.h"

#include "geometry/closest_point.h"
#include "haptics/surface/swept_sphere.h"

#include <algorithm>

namespace proxima {

namespace {

constexpr int most_steps = 64;

/// A plane is used if the centre keeps this part of the radius away from its triangle.
constexpr double sure_part = 0.5;

/// Keeps the direction that separates most.
class BestDirection {
public:
    BestDirection(const Triangle& triangle, const Vec3& p) noexcept : triangle_(triangle), p_(p) {}

    void offer(const Vec3& v) noexcept
    {
        const double length = v.norm();
        if (!(length > 0)) return;
        const Vec3 direction = v / length;
        const double apart = separation(triangle_, p_, direction);
        if (has_one_ && !(apart > apart_)) return;
        has_one_ = true;
        best_ = direction;
        apart_ = apart;
    }
    [[nodiscard]] const Vec3& best() const noexcept { return best_; }

private:
    const Triangle& triangle_;
    const Vec3& p_;
    Vec3 best_ = Vec3::Zero();
    double apart_ = 0;
    bool has_one_ = false;
};

} // namespace

Triangle MovingTriangle::at(double t) const noexcept
{
    Triangle result;
    for (int k = 0; k < 3; ++k)
        result.vertices[static_cast<std::size_t>(k)] = before[k] + t * (now[k] - before[k]);
    return result;
}

double separation(const Triangle& triangle, const Vec3& p, const Vec3& direction) noexcept
{
    return std::min({direction.dot(p - triangle[0]), direction.dot(p - triangle[1]),
                     direction.dot(p - triangle[2])});
}

Vec3 separating_direction(const Triangle& triangle, const Vec3& p) noexcept
{
    const TrianglePoint closest = closest_point(triangle, p);
    const Vec3 away = p - closest.point;
    BestDirection directions(triangle, p);
    directions.offer(away);
    const Vec3 face = unit_normal(triangle);
    directions.offer(face);
    directions.offer(-face);
    // Across a side: rounding of a short vector may tilt it along the side.
    for (int k = 0; k < 3; ++k) {
        const Vec3 side = (triangle[(k + 1) % 3] - triangle[k]).normalized();
        directions.offer(away - side.dot(away) * side);
    }
    return directions.best();
}

std::optional<double> touch_time(const MovingTriangle& triangle, double radius, const Vec3& p,
                                 const Vec3& motion, double tolerance) noexcept
{
    // A sphere that slides along a surface grazes its sides and corners at its radius: no touch.
    const double least = radius - tolerance;
    double t = 0;
    for (int step = 0; step < most_steps; ++step) {
        const Triangle there = triangle.at(t);
        const Vec3 center = p + t * motion;
        const Vec3 direction = separating_direction(there, center);
        if (!(separation(there, center, direction) > least + 0.5 * tolerance)) return t;
        // Until the first corner comes within that along this direction.
        double next = 2;
        for (int k = 0; k < 3; ++k) {
            const double begin = direction.dot(p - triangle.before[k]);
            const double end = direction.dot(p + motion - triangle.now[k]);
            if (end < least) next = std::min(next, (begin - least) / (begin - end));
        }
        if (next >= 1) return std::nullopt;
        if (!(next > t)) return t;
        t = next;
    }
    return t;
}

std::optional<MovingPlane> separating_plane(const MovingTriangle& triangle, double radius,
                                            const Vec3& p, const Vec3& motion, double t) noexcept
{
    // The contact's own plane, or else that of the beginning.
    for (const double time : {t, 0.0}) {
        MovingPlane plane;
        plane.normal = separating_direction(triangle.at(time), p + time * motion);
        if (!(separation(triangle.before, p, plane.normal) >= sure_part * radius)) continue;
        double farthest = plane.normal.dot(triangle.now[0]);
        plane.point = triangle.now[0];
        for (int k = 1; k < 3; ++k) {
            const double along = plane.normal.dot(triangle.now[k]);
            if (!(along > farthest)) continue;
            farthest = along;
            plane.point = triangle.now[k];
        }
        return plane;
    }
    return std::nullopt;
}

} // namespace proxima
