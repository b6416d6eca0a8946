#include "haptics/tool/tool_passivity.h"

#include "haptics/force/contact_force.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

/// A spring's force, with as much of its damping as the guard leaves.
Vec3 with_damping_left(const Vec3& spring, const Vec3& whole, double damping, double left) noexcept
{
    if (left >= damping) return whole;
    return spring + std::max(left, 0.0) / damping * (whole - spring);
}

} // namespace

/// Of displacements and turns together.
EnergySums ToolPassivity::sums() const noexcept
{
    EnergySums sums = linear_.sums();
    const EnergySums& turns = angular_.sums();
    sums.own += turns.own;
    sums.relative += turns.relative;
    return sums;
}

void ToolPassivity::applied(const Vec6& pull) noexcept
{
    if (mode_ != Guard::on) return;
    linear_.applied(pull.head<3>());
    angular_.applied(pull.tail<3>());
    constexpr double rounding = 1e-9; // of the device's force
    response_.applied(motions_, (pull - wanted_).norm() <= rounding * limits_.max_force);
}

Vec6 ToolPassivity::clamped(Vec6 pull) const noexcept
{
    pull.head<3>() = shortened(pull.head<3>(), limits_.max_force);
    pull.tail<3>() = shortened(pull.tail<3>(), limits_.max_turning_force);
    return pull;
}

/// The pull as the response has it. The tool's own damping gives way to the guard's; clamps then.
Vec6 ToolPassivity::guarded(const Vec6& spring, const Vec6& whole,
                            const Vec6& velocity) const noexcept
{
    if (!response_.acts()) return whole;
    const double left = limits_.max_damping - response_.damping();
    Vec6 pull = whole;
    pull.head<3>() = with_damping_left(spring.head<3>(), whole.head<3>(), limits_.damping, left);
    pull.tail<3>() =
        with_damping_left(spring.tail<3>(), whole.tail<3>(), limits_.turning_damping, left);
    return response_.answered(clamped(pull), velocity);
}

Vec6 ToolPassivity::pass(const Vec6& position, const Vec6& velocity, const TouchedGround& ground,
                         const Vec6& spring, const Vec6& whole, double seconds) noexcept
{
    if (mode_ == Guard::off) return whole;
    response_.recover(motions_, seconds);
    const Vec6 stored = response_.softness() * clamped(spring);
    linear_.add(position.head<3>(), stored.head<3>(), seconds, ground.moved.head<3>());
    angular_.add(position.tail<3>(), stored.tail<3>(), seconds, ground.moved.tail<3>());
    const EnergySums now = sums();
    const bool full = spring.head<3>().norm() >= limits_.max_force;
    const bool turns_fully = spring.tail<3>().norm() >= limits_.max_turning_force;
    for (Eigen::Index i = 0; i < 6; ++i) {
        WatchedMotion& motion = motions_[static_cast<std::size_t>(i)];
        // A force at its limit is constant, and no later for its delay.
        const bool limited = i < 3 ? full : turns_fully;
        const SwingTick tick =
            motion.swing.watch(position[i] * Vec3::UnitX(), spring[i] * Vec3::UnitX(), seconds,
                               limited ? 0 : std::numeric_limits<double>::infinity());
        const double stiffness = i < 3 ? limits_.stiffness : limits_.turning_stiffness;
        response_.judge(motions_, motion, tick, now, {stiffness, limits_.max_damping}, seconds);
    }
    WatchedMotion& shift = motions_.front(); // that of the whole force
    const Bounce bounce =
        shift.bouncing.watch(position.head<3>() - ground.moved.head<3>(), spring.head<3>(),
                             ground.velocity.head<3>(), seconds, limits_.max_force);
    response_.judge_bounce(motions_, shift, bounce, now, {limits_.stiffness, limits_.max_damping},
                           seconds);
    const Vec6 result = guarded(spring, whole, velocity);
    linear_.applied(result.head<3>());
    angular_.applied(result.tail<3>());
    wanted_ = clamped(result);
    response_.count(!spring.isZero(0));
    return mode_ == Guard::on ? result : whole;
}

void ToolPassivity::restart() noexcept
{
    motions_ = {};
    linear_.restart();
    angular_.restart();
    response_.restart();
}

void ToolPassivity::reset() noexcept
{
    restart();
    response_ = {};
}

} // namespace proxima
