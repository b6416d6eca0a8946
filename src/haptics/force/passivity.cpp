#include "haptics/force/passivity.h"

#include "haptics/force/contact_force.h"

#include <algorithm>

namespace proxima {

void PassivityGuard::applied(const Vec3& force) noexcept
{
    if (mode_ != Guard::on) return;
    account_.applied(force);
    constexpr double rounding = 1e-9; // of the device's force
    response_.applied(motions(), (force - wanted_).norm() <= rounding * max_force_);
}

/// The force as the response has it. Clamps first.
Vec3 PassivityGuard::guarded(const ContactForce& force, const Vec3& velocity) const noexcept
{
    if (!response_.acts()) return force.whole;
    return response_.answered(shortened(force.whole, max_force_), velocity);
}

Vec3 PassivityGuard::pass(const Vec3& position, const Vec3& velocity, const ContactForce& force,
                          double seconds) noexcept
{
    if (mode_ == Guard::off) return force.whole;
    response_.recover(motions(), seconds);
    account_.add(position, response_.softness() * shortened(force.spring, max_force_), seconds,
                 force.surface);
    // Without the stick-slip pull: a steady sideways pull would turn the swing's axis whenever the
    // contact's push rises and falls.
    const SwingTick tick =
        motion_.swing.watch(position, force.spring - force.aside, seconds, max_force_);
    if (force.stiffness > 0) {
        stiffness_ = force.stiffness;
        surface_damping_ = force.damping;
    }
    const Bounce bounce =
        motion_.bouncing.watch(position - force.surface, force.spring - force.aside,
                               force.surface_velocity, seconds, max_force_);
    const SwungContact contact{stiffness_, std::max(max_damping_ - surface_damping_, 0.0)};
    response_.judge(motions(), motion_, tick, account_.sums(), contact, seconds);
    response_.judge_bounce(motions(), motion_, bounce, account_.sums(), contact, seconds);
    const Vec3 result = guarded(force, velocity);
    account_.applied(result);
    wanted_ = shortened(result, max_force_);
    response_.count(force.spring != Vec3::Zero());
    return mode_ == Guard::on ? result : force.whole;
}

void PassivityGuard::restart() noexcept
{
    motion_ = {};
    account_.restart();
    response_.restart();
}

void PassivityGuard::reset() noexcept
{
    restart();
    response_ = {};
}

} // namespace proxima
