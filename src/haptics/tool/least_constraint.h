// The motion of a constrained rigid body that is nearest to the one it would make if it were free:
// Gauss' principle of least constraint ([ortega-2007]), by the dual active-set method of
// [goldfarb-1983].
//
//     minimise |u - wanted|^2   subject to   a_i . u >= b_i
//
// u has six numbers: the displacement of the origin, and the rotation vector times a length that makes
// both as stiff. The pressures lambda_i >= 0 of the constraints add up to the rest:
//     u - wanted = sum of lambda_i a_i
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

namespace proxima {

using Vec6 = Eigen::Matrix<double, 6, 1>;

struct MotionConstraint {
    Vec6 direction = Vec6::Zero(); ///< a, any length
    double bound = 0;              ///< b
};

struct ConstrainedMotion {
    Vec6 motion = Vec6::Zero();
    std::array<std::size_t, 6> active = {}; ///< constraints that hold the body back
    std::array<double, 6> pressure = {};
    std::size_t active_count = 0;
    bool solved = true; ///< false: constraints contradict each other, or the steps are used up
};

/// Constraints may be violated by up to `tolerance`. noexcept, no allocation; at most 64 steps of
/// O(constraints).
[[nodiscard]] ConstrainedMotion least_constraint(const Vec6& wanted,
                                                 std::span<const MotionConstraint> constraints,
                                                 double tolerance) noexcept;

} // namespace proxima
