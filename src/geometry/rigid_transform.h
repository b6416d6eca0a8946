// Where a rigid body stands: a rotation, then a translation.
#pragma once

#include "base/result.h"
#include "geometry/shapes.h"
#include "geometry/vec.h"

#include <array>
#include <span>

namespace proxima {

/// Takes a point p to R p + t. Made from numbers by make_rigid_transform; the default one leaves
/// everything where it is.
struct RigidTransform {
    Mat3 rotation = Mat3::Identity();
    Vec3 translation = Vec3::Zero();

    /// Each component rounded a few times, always in the same way: what is computed on moved
    /// points is exact for these.
    [[nodiscard]] Vec3 operator()(const Vec3& p) const noexcept
    {
        Vec3 moved;
        for (int i = 0; i < 3; ++i) {
            moved[i] = ((rotation(i, 0) * p[0] + rotation(i, 1) * p[1]) + rotation(i, 2) * p[2]) +
                       translation[i];
        }
        return moved;
    }
    [[nodiscard]] Triangle operator()(const Triangle& triangle) const noexcept
    {
        return {{(*this)(triangle[0]), (*this)(triangle[1]), (*this)(triangle[2])}};
    }
    /// Takes moved points back, but for rounding.
    [[nodiscard]] RigidTransform inverse() const noexcept
    {
        return {rotation.transpose(), -(rotation.transpose() * translation)};
    }
};

/// How far R^T R may be from the identity, in the sum of squares' root.
inline constexpr double rigid_tolerance = 1e-9;

/// From the row-major 3 x 4 matrix (R | t). Error invalid_argument where a number is not finite, R
/// stretches or shears (beyond rigid_tolerance) or mirrors; `where` is left empty.
[[nodiscard]] Result<RigidTransform> make_rigid_transform(std::span<const double, 12> matrix);

} // namespace proxima
