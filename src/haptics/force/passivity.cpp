#include "haptics/force/passivity.h"

#include "haptics/force/contact_force.h"
#include "haptics/force/passivity_rules.h"

#include <algorithm>
#include <cmath>

namespace proxima {

void PassivityGuard::mark() noexcept
{
    cycle_began_ = leg_began_;
    leg_began_ = account_.sums();
    last_leg_late_ = leg_late_;
    leg_late_ = late_;
}

void PassivityGuard::applied(const Vec3& force) noexcept
{
    if (mode_ != Guard::on) return;
    account_.applied(force);
    constexpr double rounding = 1e-9; // of the device's force
    late_ = (force - wanted_).norm() > rounding * max_force_ ? late_ + 1 : 0;
    leg_late_ = std::max(leg_late_, late_);
}

void PassivityGuard::soften(double factor) noexcept
{
    report_.softenings += softness_ >= 1 ? 1U : 0U;
    softness_ = std::max(softness_ * factor, passivity_rule::least_softness);
    report_.lowest_softness = std::min(report_.lowest_softness, softness_);
}

/// Adds damping, or softens where the damping that the device allows is there and is not enough.
void PassivityGuard::answer(const SwingTick& tick, double needed, bool brief) noexcept
{
    const double most = std::max(max_damping_ - surface_damping_, 0.0);
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
    leg_began_ = cycle_began_ = account_.sums();
    kept_legs_ = 0;
    trust_ = 0;
}

/// Ends the damping, at a turn of the motion, where a hand makes it: legs do not fade though the last
/// cycle took energy.
void PassivityGuard::trust_hand(double given) noexcept
{
    kept_legs_ = swing_.is_kept() ? kept_legs_ + 1 : 0;
    if (!(damping_ > 0) || kept_legs_ < passivity_rule::hand_legs || given > 0 || swing_.is_fast())
        return;
    damping_ = 0;
    trust_ = passivity_rule::recovery;
    trusted_leg_ = swing_.last_leg();
}

/// Weighs a leg that did not fade by the energy of the cycle that it ends.
void PassivityGuard::judge(const SwingTick& tick, double seconds) noexcept
{
    if (!tick.turned && !tick.reported) return;
    const EnergySums& now = account_.sums();
    const double given = now.most_given_since(cycle_began_);
    const double motion = now.motion - cycle_began_.motion;
    const double in_contact = now.motion_in_contact - cycle_began_.motion_in_contact;
    gives_ = given > passivity_rule::least_device_damping * motion;
    // Beyond doubt, as for gives_.
    if (tick.turned) trust_hand(given + passivity_rule::least_device_damping * motion);
    if (!tick.reported || !(tick.legs >= passivity_rule::least_legs || tick.quick) || !gives_)
        return;
    const bool brief = passivity_rule::is_brief(tick.contact, stiffness_,
                                                std::max(leg_late_, last_leg_late_), seconds);
    const bool trusted = trust_ > 0 && tick.length < 2 * trusted_leg_;
    if (trusted && !brief && !tick.fast) return;
    report_.most_given = std::max(report_.most_given, given);
    answer(tick, in_contact > 0 ? std::max(given, 0.0) / in_contact : 0, brief);
}

/// Less than by s, so that a softened wall can stop what made it swing; never more than is allowed.
double PassivityGuard::softened_damping() const noexcept
{
    return std::sqrt(softness_) * damping_;
}

/// Softening and damping fade, in this order, once the contact no longer swings.
void PassivityGuard::recover(double seconds) noexcept
{
    trust_ = std::max(trust_ - seconds, 0.0);
    if (softness_ < 1) {
        softened_seconds_ += seconds;
        report_.longest_softening = std::max(report_.longest_softening, softened_seconds_);
    }
    if (swing_.is_swinging() && (gives_ || swing_.is_fast())) return;
    if (softness_ < 1) {
        softness_ = std::min(softness_ * std::exp2(seconds / passivity_rule::recovery), 1.0);
        if (softness_ >= 1) softened_seconds_ = 0;
    } else if (damping_ > 0) {
        damping_ *= std::exp2(-seconds / passivity_rule::recovery);
        if (damping_ < passivity_rule::least_device_damping) damping_ = 0;
    }
}

/// The force with the guard's damping, which never makes it pull the other way, and softened. Clamps
/// first: a part of an excessive force may still be the device's limit.
Vec3 PassivityGuard::guarded(const ContactForce& force, const Vec3& velocity) const noexcept
{
    if (softness_ >= 1 && !(damping_ > 0)) return force.whole;
    Vec3 whole = shortened(force.whole, max_force_);
    const double size = whole.norm();
    if (!(size > 0)) return whole;
    const Vec3 along = whole / size;
    const Vec3 damped = -softened_damping() * velocity;
    const double pull = std::min(damped.dot(along) + softness_ * size, 0.0);
    return softness_ * whole + damped - pull * along;
}

Vec3 PassivityGuard::pass(const Vec3& position, const Vec3& velocity, const ContactForce& force,
                          double seconds) noexcept
{
    if (mode_ == Guard::off) return force.whole;
    recover(seconds);
    account_.add(position, softness_ * shortened(force.spring, max_force_), seconds);
    // Without the stick-slip pull: a steady sideways pull would turn the swing's axis whenever the
    // contact's push rises and falls.
    const SwingTick tick = swing_.watch(position, force.spring - force.aside, seconds, max_force_);
    if (force.stiffness > 0) {
        stiffness_ = force.stiffness;
        surface_damping_ = force.damping;
    }
    judge(tick, seconds);
    if (tick.turned) mark();
    const Vec3 result = guarded(force, velocity);
    account_.applied(result);
    wanted_ = shortened(result, max_force_);
    const bool touches = force.spring != Vec3::Zero();
    report_.damped_ticks += touches && damping_ > 0 ? 1U : 0U;
    report_.softened_ticks += touches && softness_ < 1 ? 1U : 0U;
    return mode_ == Guard::on ? result : force.whole;
}

void PassivityGuard::restart() noexcept
{
    swing_.restart();
    account_.restart();
    leg_began_ = cycle_began_ = {};
    gives_ = false;
    kept_legs_ = 0;
    trust_ = 0;
    late_ = leg_late_ = last_leg_late_ = 0;
}

void PassivityGuard::reset() noexcept
{
    restart();
    damping_ = 0;
    softness_ = 1;
    softened_seconds_ = 0;
    report_ = {};
}

} // namespace proxima
