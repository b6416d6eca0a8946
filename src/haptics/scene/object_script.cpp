#include "haptics/scene/object_script.h"

#include "base/text.h"
#include "geometry/length.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace proxima {

namespace {

/// Lengths of axes and displacements: their squares are normal numbers.
constexpr double least_length = 1e-100;
constexpr double most_length = 1e100;

/// s: of a period. No tick is shorter, and no session a thousandth as long.
constexpr double least_period = 1e-6;
constexpr double most_period = 1e9;

/// 0 at the beginning, 1 after half the period, 0 at its end; at rest at both ends.
double to_and_fro(double seconds, double period) noexcept
{
    const double part = std::fmod(seconds, period) / period;
    return 0.5 * (1 - std::cos(2 * std::numbers::pi * part));
}

/// The fastest rotation, radians per second.
double fastest_of(const ObjectScript& script) noexcept
{
    switch (script.kind) {
    case ObjectMotionKind::spin:
        return std::abs(script.angle);
    case ObjectMotionKind::rock:
        return std::abs(script.angle) * 2 * std::numbers::pi / script.seconds;
    case ObjectMotionKind::rest:
    case ObjectMotionKind::swing:
        break;
    }
    return 0;
}

RigidTransform turned(const RigidTransform& begin, const Vec3& middle, const Vec3& axis,
                      double angle) noexcept
{
    const Mat3 turn = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    const Vec3 center = begin(middle);
    return {turn * begin.rotation, center + turn * (begin.translation - center)};
}

} // namespace

Status check_script(const ObjectScript& script)
{
    if (script.kind == ObjectMotionKind::rest) return {};
    const bool finite =
        script.along.allFinite() && std::isfinite(script.angle) && std::isfinite(script.seconds);
    if (!finite) return fail(ErrorCode::invalid_argument, "the numbers of a motion must be finite");
    const bool turns = script.kind != ObjectMotionKind::swing;
    const double length = length_of(script.along);
    if (!(length >= least_length && length <= most_length)) {
        return fail(ErrorCode::invalid_argument,
                    concat(turns ? "the axis" : "the displacement", " of a motion must be ",
                           least_length, " to ", most_length, " long, not ", length));
    }
    const bool has_period = script.kind != ObjectMotionKind::spin;
    if (has_period && !(script.seconds >= least_period && script.seconds <= most_period)) {
        return fail(ErrorCode::invalid_argument,
                    concat("the period of a motion must be ", least_period, " to ", most_period,
                           " seconds, not ", script.seconds));
    }
    if (!(fastest_of(script) <= fastest_turn)) {
        return fail(ErrorCode::invalid_argument,
                    "an object must not rotate faster than 25 radians (1,432 degrees) per second");
    }
    return {};
}

RigidTransform pose_at(const ObjectScript& script, const RigidTransform& begin, const Vec3& middle,
                       double seconds) noexcept
{
    switch (script.kind) {
    case ObjectMotionKind::rest:
        break;
    case ObjectMotionKind::spin: {
        const double angle = std::fmod(script.angle * seconds, 2 * std::numbers::pi);
        return turned(begin, middle, script.along, angle);
    }
    case ObjectMotionKind::rock: {
        const double part = std::fmod(seconds, script.seconds) / script.seconds;
        return turned(begin, middle, script.along,
                      script.angle * std::sin(2 * std::numbers::pi * part));
    }
    case ObjectMotionKind::swing:
        return {begin.rotation,
                begin.translation + to_and_fro(seconds, script.seconds) * script.along};
    }
    return begin;
}

Box swept_bounds(const ObjectScript& script, const RigidTransform& begin,
                 const Box& bounds) noexcept
{
    Box reach;
    for (unsigned corner = 0; corner < 8; ++corner) {
        Vec3 p;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<Eigen::Index>(axis);
            p[i] = (corner >> axis & 1U) != 0 ? bounds.upper[i] : bounds.lower[i];
        }
        reach.extend(begin(p));
    }
    if (fastest_of(script) > 0) {
        const Vec3 center = begin(bounds.center());
        const double size = bounds.extent().norm() / 2;
        reach.extend(center - Vec3::Constant(size));
        reach.extend(center + Vec3::Constant(size));
    }
    if (script.kind == ObjectMotionKind::swing) {
        const Box there = reach;
        reach.extend(there.lower + script.along);
        reach.extend(there.upper + script.along);
    }
    return reach;
}

} // namespace proxima
