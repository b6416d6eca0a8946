#include "haptics/tool/friction_constraint.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;
using Eigen::Vector2d;

/// The stiffness of the springs that stand for friction, in the first and the second pass; that of the
/// body's own spring is 1. Soft springs find which contacts slide, stiff ones let the others stick.
constexpr std::array<double, 2> friction_springs = {1e3, 1e6};
/// The first pass ends where steps change the energy of soft springs by less than this part squared.
constexpr double soft_springs_end = 0.01;
constexpr std::size_t max_newton_steps = 40;
constexpr int max_part_searches = 60;

/// Springs that yield: minimises the energy of the body and of its frictions.
class FrictionSprings {
public:
    FrictionSprings(Vec6 wanted, std::span<const MotionFriction> frictions) noexcept
        : wanted_(std::move(wanted)), frictions_(frictions)
    {
        preload_.fill(Vector2d::Zero());
    }

    /// The friction of a contact that slid so far.
    [[nodiscard]] Vector2d force(std::size_t k, const Vector2d& slid) const noexcept
    {
        const Vector2d trial = preload_[k] + spring_ * slid;
        const double size = trial.norm();
        const double limit = frictions_[k].limit;
        return size > limit ? Vector2d(limit / size * trial) : trial;
    }
    /// The springs get as stiff, and keep the forces that they have in the motion.
    void stiffen(double stiffness, const Vec6& motion) noexcept
    {
        for (std::size_t k = 0; k < frictions_.size(); ++k)
            preload_[k] = force(k, frictions_[k].slid(motion));
        spring_ = stiffness;
    }
    [[nodiscard]] Vec6 slope(const Vec6& motion) const noexcept
    {
        Vec6 sum = motion - wanted_;
        for (std::size_t k = 0; k < frictions_.size(); ++k) {
            const MotionFriction& friction = frictions_[k];
            sum += friction.along.transpose() * force(k, friction.slid(motion));
        }
        return sum;
    }
    [[nodiscard]] Mat6 stiffness(const Vec6& motion) const noexcept
    {
        Mat6 sum = Mat6::Identity();
        for (std::size_t k = 0; k < frictions_.size(); ++k) {
            const auto& along = frictions_[k].along;
            const Vector2d trial = preload_[k] + spring_ * frictions_[k].slid(motion);
            const double size = trial.norm();
            Eigen::Matrix2d own = spring_ * Eigen::Matrix2d::Identity();
            if (size > frictions_[k].limit) {
                const Vector2d e = trial / size;
                own = spring_ * frictions_[k].limit / size *
                      (Eigen::Matrix2d::Identity() - e * e.transpose());
            }
            sum += along.transpose() * own * along;
        }
        return sum;
    }
    /// The part of the step that leaves the least energy, 0 to 1: where its slope along the step is
    /// zero, by the Illinois method.
    [[nodiscard]] double best_part(const Vec6& motion, const Vec6& step) const noexcept
    {
        const auto slope_at = [&](double part) { return step.dot(slope(motion + part * step)); };
        double low = 0;
        double high = 1;
        double below = slope_at(0);
        double above = slope_at(1);
        if (!(below < 0)) return 0;
        const double small = -1e-9 * below;
        if (above <= small) return 1;
        int side = 0;
        double part = 1;
        for (int search = 0; search < max_part_searches; ++search) {
            part = std::clamp(low - below * (high - low) / (above - below), low, high);
            const double value = slope_at(part);
            if (std::abs(value) <= small) break;
            if (value < 0) {
                low = part;
                below = value;
                if (side < 0) above /= 2;
                side = -1;
            } else {
                high = part;
                above = value;
                if (side > 0) below /= 2;
                side = 1;
            }
        }
        return part;
    }

private:
    Vec6 wanted_;
    std::span<const MotionFriction> frictions_;
    double spring_ = 0;
    std::array<Vector2d, max_frictions> preload_; ///< the forces at rest
};

} // namespace

FrictionalMotion least_constraint_with_friction(const Vec6& wanted,
                                                std::span<const MotionConstraint> constraints,
                                                std::span<const MotionFriction> frictions,
                                                double tolerance,
                                                std::span<MotionConstraint> scratch) noexcept
{
    FrictionalMotion result;
    result.friction.fill(Vector2d::Zero());
    ConstrainedMotion& found = result.constrained;
    if (frictions.empty()) {
        found = least_constraint(wanted, constraints, tolerance);
        return result;
    }
    FrictionSprings springs(wanted, frictions);
    const auto scaled = scratch.first(constraints.size());
    Vec6 motion = Vec6::Zero();
    for (const double stiffness : friction_springs) {
        springs.stiffen(stiffness, motion);
        const bool is_last = stiffness == friction_springs.back();
        const double small =
            is_last ? 0.1 * tolerance : soft_springs_end * wanted.norm() / std::sqrt(stiffness);
        double change = 0;
        do {
            ++result.steps;
            // In terms of y = L^T u, where L L^T is the stiffness, the energy is |y - y_wanted|^2 / 2.
            const Eigen::LLT<Mat6> factor(springs.stiffness(motion));
            const auto lower = factor.matrixL();
            const auto upper = factor.matrixU();
            const Vec6 goal = motion - factor.solve(springs.slope(motion));
            for (std::size_t i = 0; i < constraints.size(); ++i)
                scaled[i] = {lower.solve(constraints[i].direction), constraints[i].bound};
            found = least_constraint(upper * goal, scaled, tolerance);
            if (!found.solved) return result;
            const Vec6 step = upper.solve(found.motion) - motion;
            change = (upper * step).norm();
            // The first motion, none, need not be allowed.
            motion += result.steps == 1 ? step : springs.best_part(motion, step) * step;
        } while (change > small && result.steps < max_newton_steps);
    }
    for (std::size_t k = 0; k < frictions.size(); ++k)
        result.friction[k] = springs.force(k, frictions[k].slid(motion));
    found.motion = motion;
    return result;
}

} // namespace proxima
