#include "lab/simulated_hand.h"

#include "base/check.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// exp(a) by its series, after enough halvings.
Mat3 exponential(Mat3 a) noexcept
{
    const int halvings = std::max(0, std::ilogb(a.cwiseAbs().maxCoeff() / 0.03) + 1);
    a /= std::ldexp(1.0, halvings);
    Mat3 sum = Mat3::Identity();
    Mat3 term = Mat3::Identity();
    for (int i = 1; i <= 14; ++i) {
        term = (term * a / i).eval();
        sum += term;
    }
    for (int i = 0; i < halvings; ++i) sum = (sum * sum).eval();
    return sum;
}

} // namespace

SimulatedHand::SimulatedHand(const HandModel& model, const Vec3& at) noexcept
    : model_(model), position_(at), reported_before_(at)
{
    PROXIMA_CHECK_GT(model.mass, 0);
    PROXIMA_CHECK_GT(model.tick_seconds, 0);
    PROXIMA_CHECK_GE(model.delay_ticks, 0);
    PROXIMA_CHECK_LE(model.delay_ticks, max_hand_delay);
    // State (x - target, v, a) with a constant over the tick.
    Mat3 system = Mat3::Zero();
    system(0, 1) = 1;
    system(1, 0) = -model.hand_stiffness / model.mass;
    system(1, 1) = -(model.device_damping + model.hand_damping) / model.mass;
    system(1, 2) = 1;
    const Mat3 tick = exponential(system * model.tick_seconds);
    free_xx_ = tick(0, 0);
    free_xv_ = tick(0, 1);
    free_vx_ = tick(1, 0);
    free_vv_ = tick(1, 1);
    push_x_ = tick(0, 2);
    push_v_ = tick(1, 2);
    delayed_.fill(Vec3::Zero());
    reported_before_ = reported_position();
}

Vec3 SimulatedHand::reported_position() const noexcept
{
    const double step = model_.encoder_step;
    if (!(step > 0)) return position_;
    return (position_ / step).array().round() * step;
}

DeviceState SimulatedHand::state() const noexcept
{
    DeviceState state;
    state.pose.translation = reported_position();
    state.velocity = model_.velocity == VelocityEstimate::exact
                         ? velocity_
                         : Vec3((state.pose.translation - reported_before_) / model_.tick_seconds);
    return state;
}

void SimulatedHand::set_motion(const Vec3& position, const Vec3& velocity) noexcept
{
    position_ = position;
    velocity_ = velocity;
    reported_before_ = reported_position();
}

void SimulatedHand::step(const Vec3& force, const Vec3& target) noexcept
{
    reported_before_ = reported_position();
    const std::size_t slots = static_cast<std::size_t>(model_.delay_ticks) + 1;
    delayed_[ticks_ % slots] = force;
    ++ticks_;
    const Vec3 felt = delayed_[ticks_ % slots];

    Vec3 push = felt / model_.mass;
    const Vec3 offset = position_ - target;
    const double friction = model_.coulomb_friction / model_.mass;
    if (friction > 0) {
        const double speed = velocity_.norm();
        const Vec3 driving = push - offset * (model_.hand_stiffness / model_.mass);
        if (!(speed > 0) && driving.norm() <= friction) return; // it sticks
        const Vec3 against = speed > 0 ? Vec3(velocity_ / speed) : Vec3(driving.normalized());
        push -= friction * against;
        const Vec3 after = free_vx_ * offset + free_vv_ * velocity_ + push_v_ * push;
        if (speed > 0 && after.dot(velocity_) <= 0) {
            // It comes to rest within the tick; the next tick decides whether it moves on.
            const double slowing = (velocity_ - after).norm();
            const double part = slowing > 0 ? speed / slowing : 0;
            position_ += velocity_ * (0.5 * std::min(part, 1.0) * model_.tick_seconds);
            velocity_ = Vec3::Zero();
            return;
        }
    }
    const Vec3 velocity = velocity_;
    position_ = target + free_xx_ * offset + free_xv_ * velocity + push_x_ * push;
    velocity_ = free_vx_ * offset + free_vv_ * velocity + push_v_ * push;
}

} // namespace proxima
