#include "haptics/tool/tool_passivity.h"

#include "haptics/force/contact_force.h"
#include "haptics/force/passivity_rules.h"

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
    for (std::size_t delay = 0; delay < sums.given.size(); ++delay)
        sums.given[delay] += turns.given[delay];
    sums.motion += turns.motion;
    sums.motion_in_contact += turns.motion_in_contact;
    return sums;
}

void ToolPassivity::applied(const Vec6& pull) noexcept
{
    if (mode_ != Guard::on) return;
    linear_.applied(pull.head<3>());
    angular_.applied(pull.tail<3>());
    constexpr double rounding = 1e-9; // of the device's force
    late_ = (pull - wanted_).norm() > rounding * limits_.max_force ? late_ + 1 : 0;
    for (Axis& axis : axes_) axis.leg_late = std::max(axis.leg_late, late_);
}

void ToolPassivity::soften(double factor) noexcept
{
    report_.softenings += softness_ >= 1 ? 1U : 0U;
    softness_ = std::max(softness_ * factor, passivity_rule::least_softness);
    report_.lowest_softness = std::min(report_.lowest_softness, softness_);
}

/// Adds damping, or softens where the damping that the device allows is there and is not enough.
void ToolPassivity::answer(const SwingTick& tick, double needed, bool brief) noexcept
{
    const double most = limits_.max_damping;
    if (damping_ < passivity_rule::nearly_all * most) {
        report_.swings += damping_ > 0 ? 0U : 1U;
        const double step = brief || tick.quick ? most : passivity_rule::firmness * needed;
        damping_ = std::min(damping_ + step, most);
        report_.most_damping = std::max(report_.most_damping, damping_);
    } else if (!brief && !tick.quick) {
        return;
    } else if (!tick.quick) {
        soften(passivity_rule::softening);
    }
    if (tick.quick) soften(passivity_rule::least_softness);
    // What was given before the answer says nothing about what is given after it.
    for (Axis& axis : axes_) {
        axis.leg_began = axis.cycle_began = sums();
        axis.kept_legs = 0;
    }
    trust_ = 0;
}

/// Ends the damping, at a turn of the motion, where a hand makes it.
void ToolPassivity::trust_hand(Axis& axis, double given) noexcept
{
    axis.kept_legs = axis.swing.is_kept() ? axis.kept_legs + 1 : 0;
    if (!(damping_ > 0) || axis.kept_legs < passivity_rule::hand_legs || given > 0 ||
        axis.swing.is_fast())
        return;
    for (const Axis& other : axes_) {
        if (other.swing.is_swinging() && other.swing.last_leg() > axis.swing.last_leg()) return;
    }
    damping_ = 0;
    trust_ = passivity_rule::recovery;
    for (Axis& each : axes_) each.trusted_leg = each.swing.last_leg();
}

/// Weighs a leg that did not fade by the energy of the cycle that it ends.
void ToolPassivity::judge(Axis& axis, const SwingTick& tick, double stiffness,
                          double seconds) noexcept
{
    if (!tick.turned && !tick.reported) return;
    const EnergySums now = sums();
    const double given = now.most_given_since(axis.cycle_began);
    const double motion = now.motion - axis.cycle_began.motion;
    const double in_contact = now.motion_in_contact - axis.cycle_began.motion_in_contact;
    axis.gives = given > passivity_rule::least_device_damping * motion;
    // Beyond doubt, as for gives.
    if (tick.turned) trust_hand(axis, given + passivity_rule::least_device_damping * motion);
    if (!tick.reported || !(tick.legs >= passivity_rule::least_legs || tick.quick) || !axis.gives)
        return;
    const bool brief = passivity_rule::is_brief(
        tick.contact, stiffness, std::max(axis.leg_late, axis.last_leg_late), seconds);
    const bool trusted = trust_ > 0 && tick.length < 2 * axis.trusted_leg;
    if (trusted && !brief && !tick.fast) return;
    report_.most_given = std::max(report_.most_given, given);
    answer(tick, in_contact > 0 ? std::max(given, 0.0) / in_contact : 0, brief);
}

/// Less than by s, so that a softened contact can stop what made it swing.
double ToolPassivity::softened_damping() const noexcept
{
    return std::sqrt(softness_) * damping_;
}

bool ToolPassivity::is_swinging() const noexcept
{
    return std::ranges::any_of(axes_, [](const Axis& axis) {
        return axis.swing.is_swinging() && (axis.gives || axis.swing.is_fast());
    });
}

/// Softening and damping fade, in this order, once the contact no longer swings.
void ToolPassivity::recover(double seconds) noexcept
{
    trust_ = std::max(trust_ - seconds, 0.0);
    if (softness_ < 1) {
        softened_seconds_ += seconds;
        report_.longest_softening = std::max(report_.longest_softening, softened_seconds_);
    }
    if (is_swinging()) return;
    if (softness_ < 1) {
        softness_ = std::min(softness_ * std::exp2(seconds / passivity_rule::recovery), 1.0);
        if (softness_ >= 1) softened_seconds_ = 0;
    } else if (damping_ > 0) {
        damping_ *= std::exp2(-seconds / passivity_rule::recovery);
        if (damping_ < passivity_rule::least_device_damping) damping_ = 0;
    }
}

Vec6 ToolPassivity::clamped(Vec6 pull) const noexcept
{
    pull.head<3>() = shortened(pull.head<3>(), limits_.max_force);
    pull.tail<3>() = shortened(pull.tail<3>(), limits_.max_turning_force);
    return pull;
}

/// The pull with the guard's damping, which never turns it round, and softened. Clamps first: a part of
/// an excessive force may still be the device's limit.
Vec6 ToolPassivity::guarded(const Vec6& spring, const Vec6& whole,
                            const Vec6& velocity) const noexcept
{
    if (softness_ >= 1 && !(damping_ > 0)) return whole;
    const double left = limits_.max_damping - softened_damping();
    Vec6 pull = whole;
    pull.head<3>() = with_damping_left(spring.head<3>(), whole.head<3>(), limits_.damping, left);
    pull.tail<3>() =
        with_damping_left(spring.tail<3>(), whole.tail<3>(), limits_.turning_damping, left);
    pull = clamped(pull);
    const double size = pull.norm();
    if (!(size > 0)) return pull;
    const Vec6 along = pull / size;
    const Vec6 damped = -softened_damping() * velocity;
    const double back = std::min(damped.dot(along) + softness_ * size, 0.0);
    return softness_ * pull + damped - back * along;
}

Vec6 ToolPassivity::pass(const Vec6& position, const Vec6& velocity, const Vec6& spring,
                         const Vec6& whole, double seconds) noexcept
{
    if (mode_ == Guard::off) return whole;
    recover(seconds);
    const Vec6 stored = softness_ * clamped(spring);
    linear_.add(position.head<3>(), stored.head<3>(), seconds);
    angular_.add(position.tail<3>(), stored.tail<3>(), seconds);
    const bool full = spring.head<3>().norm() >= limits_.max_force;
    const bool turns_fully = spring.tail<3>().norm() >= limits_.max_turning_force;
    for (Eigen::Index i = 0; i < 6; ++i) {
        Axis& axis = axes_[static_cast<std::size_t>(i)];
        // A force at its limit is constant, and no later for its delay.
        const bool limited = i < 3 ? full : turns_fully;
        const SwingTick tick =
            axis.swing.watch(position[i] * Vec3::UnitX(), spring[i] * Vec3::UnitX(), seconds,
                             limited ? 0 : std::numeric_limits<double>::infinity());
        judge(axis, tick, i < 3 ? limits_.stiffness : limits_.turning_stiffness, seconds);
        if (!tick.turned) continue;
        axis.cycle_began = axis.leg_began;
        axis.leg_began = sums();
        axis.last_leg_late = axis.leg_late;
        axis.leg_late = late_;
    }
    const Vec6 result = guarded(spring, whole, velocity);
    linear_.applied(result.head<3>());
    angular_.applied(result.tail<3>());
    wanted_ = clamped(result);
    const bool touches = !spring.isZero(0);
    report_.damped_ticks += touches && damping_ > 0 ? 1U : 0U;
    report_.softened_ticks += touches && softness_ < 1 ? 1U : 0U;
    return mode_ == Guard::on ? result : whole;
}

void ToolPassivity::restart() noexcept
{
    axes_ = {};
    linear_.restart();
    angular_.restart();
    trust_ = 0;
    late_ = 0;
}

void ToolPassivity::reset() noexcept
{
    restart();
    damping_ = 0;
    softness_ = 1;
    softened_seconds_ = 0;
    report_ = {};
}

} // namespace proxima
