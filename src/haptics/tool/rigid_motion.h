// Motions of a rigid tool: its origin moves evenly along a straight line while it turns evenly about
// one axis through the origin.
//
//     pose(t) = (exp(t w) R, c + t v)        0 <= t <= 1
#pragma once

#include "proxima/geometry.h"

namespace proxima {

/// Displacement of the tool's origin and rotation vector about it, in the scene's axes.
struct Twist {
    Vec3 linear = Vec3::Zero();
    Vec3 angular = Vec3::Zero(); ///< radians

    [[nodiscard]] Twist scaled(double factor) const noexcept
    {
        return {Vec3(factor * linear), Vec3(factor * angular)};
    }
    /// Longest path of a point at most `reach` from the origin.
    [[nodiscard]] double path_length(double reach) const noexcept
    {
        return linear.norm() + reach * angular.norm();
    }
};

/// The rotation vector of a rotation, of length 0 to pi.
[[nodiscard]] Vec3 rotation_vector(const Mat3& rotation) noexcept;

/// What takes the tool from one pose to the other.
[[nodiscard]] Twist twist_between(const RigidTransform& from, const RigidTransform& to) noexcept;

/// The pose after part t of the twist, its rotation orthonormal up to rounding.
[[nodiscard]] RigidTransform moved_by(const RigidTransform& pose, const Twist& twist,
                                      double t) noexcept;

/// How far, at most, points within `reach` of the origin are from the chords of their arcs: the tool
/// turned by `angle` radians.
[[nodiscard]] inline double chord_error(double angle, double reach) noexcept
{
    return reach * angle * angle / 8;
}

} // namespace proxima
