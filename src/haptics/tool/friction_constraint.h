// The least constrained motion of a rigid body whose contacts resist sliding (Coulomb's law with given
// normal loads).
//
//     minimise |u - wanted|^2 / 2 + sum of limit_k |T_k u - s_k|   subject to   a_i . u >= b_i
//
// T_k u - s_k is how far the body slides at contact k, where the other body moves by s_k along the
// surface; limit_k = mu_k times its load. With the contacts' pressures lambda_i and frictions f_k the
// motion balances:
//     wanted - u + sum of lambda_i a_i = sum of T_k^T f_k,    |f_k| <= limit_k
// A contact sticks, T_k u = s_k, or f_k has its limit and points where the contact slides. The problem is
// convex, so the motion is unique. Each friction is that of a spring that yields at the limit: soft first,
// then stiff and with the force that the soft one had. Newton's method finds the motion, each step by
// least_constraint() in the metric of the springs.
#pragma once

#include "haptics/tool/least_constraint.h"

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

namespace proxima {

struct MotionFriction {
    Eigen::Matrix<double, 2, 6> along; ///< T: sliding along two directions at right angles
    Eigen::Vector2d carried = Eigen::Vector2d::Zero(); ///< s: the other body's motion along them
    double limit = 0;                                  ///< at least 0

    [[nodiscard]] Eigen::Vector2d slid(const Vec6& motion) const noexcept
    {
        return along * motion - carried;
    }
};

inline constexpr std::size_t max_frictions = 6;

struct FrictionalMotion {
    ConstrainedMotion constrained;
    std::array<Eigen::Vector2d, max_frictions> friction; ///< f, by contact
    std::size_t steps = 0;                               ///< of Newton's method
};

/// Constraints may be violated by up to `tolerance`. A contact that sticks slides by some millionths of
/// the wanted motion. `scratch` has room for all constraints. noexcept, no allocation; at most 40
/// steps, each like least_constraint().
/// \pre at most max_frictions frictions
[[nodiscard]] FrictionalMotion
least_constraint_with_friction(const Vec6& wanted, std::span<const MotionConstraint> constraints,
                               std::span<const MotionFriction> frictions, double tolerance,
                               std::span<MotionConstraint> scratch) noexcept;

} // namespace proxima
