#include "haptics/tool/tool_guard.h"

namespace proxima {

namespace {

/// How stiff turning is at the lever.
constexpr double at_lever(double torsional) noexcept
{
    return torsional / (turning_lever * turning_lever);
}

ForceOptions torque_options(const ToolRenderOptions& options) noexcept
{
    ForceOptions torque = options.force;
    torque.max_slew = options.max_torque_slew;
    return torque;
}

Vec6 at_lever(const Wrench& wrench) noexcept
{
    Vec6 result;
    result << wrench.force, wrench.torque / turning_lever;
    return result;
}

Vec6 at_lever(const Twist& twist) noexcept
{
    Vec6 result;
    result << twist.linear, turning_lever * twist.angular;
    return result;
}

} // namespace

ToolGuard::ToolGuard(const ToolRenderOptions& options, const DeviceLimits& device)
    : mode_(options.guard), gives_torque_(device.max_torque > 0),
      force_(options.force, device.max_force),
      torque_(torque_options(options), gives_torque_ ? device.max_torque : 1),
      force_ramp_(device.max_damping), torque_ramp_(device.max_damping),
      passivity_(options.guard, {.max_force = device.max_force,
                                 .max_turning_force = device.max_torque / turning_lever,
                                 .max_damping = device.max_damping,
                                 .stiffness = options.force.stiffness,
                                 .turning_stiffness = at_lever(options.torsional_stiffness),
                                 .damping = options.force.damping,
                                 .turning_damping = at_lever(options.torsional_damping)})
{}

void ToolGuard::reset() noexcept
{
    force_.restart();
    torque_.restart();
    force_ramp_.restart();
    torque_ramp_.restart();
    passivity_.reset();
    frame_.restart();
}

/// The pull after ramp observers and passivity guard; with Guard::observe bit for bit as it came.
Wrench ToolGuard::guarded(const ToolPull& pull, double seconds) noexcept
{
    const Vec6 ground = at_lever(pull.ground.value_or(Twist{}));
    Vec6 relative = at_lever(pull.travel) - ground;
    Vec6 travel = at_lever(pull.travel);
    Vec6 own_velocity = travel / seconds;
    if (pull.ground_seconds > 0) {
        travel -= frame_.step(pull.ground ? &ground : nullptr, pull.ground_seconds);
        own_velocity -= frame_.velocity();
    }
    if (!gives_torque_) { // nothing can damp turns
        relative.tail<3>().setZero();
        travel.tail<3>().setZero();
        own_velocity.tail<3>().setZero();
    }
    relative_ += relative;
    position_ += travel;
    const Vec6 velocity = relative / seconds;
    const Vec6 spring = at_lever(pull.spring);
    Vec6 whole = at_lever(pull.whole);
    // Ramps change the energy that the springs have stored.
    const bool ramps = ramp() < 1;
    if (ramps || pull.jumped) passivity_.restart();
    if (!ramps || spring.isZero(0)) {
        force_ramp_.restart();
        torque_ramp_.restart();
    } else if (mode_ == Guard::on) {
        whole.head<3>() =
            force_ramp_.pass(relative_.head<3>(), velocity.head<3>(), whole.head<3>(), seconds);
        whole.tail<3>() =
            torque_ramp_.pass(relative_.tail<3>(), velocity.tail<3>(), whole.tail<3>(), seconds);
    }
    TouchedGround touched;
    touched.moved = position_ - relative_;
    if (pull.ground_seconds > 0) touched.velocity = ground / pull.ground_seconds;
    const Vec6 result = passivity_.pass(position_, own_velocity, touched, spring, whole, seconds);
    return {result.head<3>(), turning_lever * result.tail<3>()};
}

Wrench ToolGuard::pass(const ToolPull& pull, double seconds, Patch patch) noexcept
{
    if (pull.jumped) {
        force_.restart();
        torque_.restart();
    }
    Wrench wanted = pull.whole;
    // Others are refused below.
    const bool finite = wanted.force.allFinite() && wanted.torque.allFinite();
    if (mode_ != Guard::off && finite) wanted = guarded(pull, seconds);
    Wrench given = {force_.pass(wanted.force, seconds, patch),
                    torque_.pass(wanted.torque, seconds, patch)};
    const Vec6 applied = at_lever(given);
    passivity_.applied(applied);
    force_ramp_.applied(applied.head<3>());
    torque_ramp_.applied(applied.tail<3>());
    return given;
}

} // namespace proxima
