#include "lab/self_test_hand.h"

#include <cmath>

namespace proxima {

namespace {

constexpr double full_turn = 6.283185307179586;

/// Within a step of the middle, so that the encoder's steps do not favour it.
const Vec3 middle(0.0011, -0.0007, 0.0004); // m

constexpr double let_go_after = 1; // s

} // namespace

HandModel SelfTestHand::part_of(HandModel model) noexcept
{
    model.tick_seconds /= parts;
    model.delay_ticks = 0;
    return model;
}

HandModel SelfTestHand::released(HandModel model) noexcept
{
    model.hand_stiffness = model.hand_damping = 0;
    return model;
}

SelfTestHand::SelfTestHand(std::string name, const HandModel& model, const DeviceLimits& limits)
    : model_(model), holding_(part_of(model), middle), free_(part_of(released(model)), middle),
      reported_(holding_.state().pose.translation)
{
    info_.name = std::move(name);
    info_.model = "a simulated hand";
    info_.limits = limits;
    info_.pushes = false;
    info_.stillness = Stillness::usual;
    delayed_.fill(Vec3::Zero());
}

DeviceReading SelfTestHand::read() noexcept
{
    DeviceReading reading;
    const SimulatedHand& hand = holds_ ? holding_ : free_;
    reading.state = hand.state();
    const Vec3& position = reading.state.pose.translation;
    reading.state.velocity = model_.velocity == VelocityEstimate::exact
                                 ? hand.velocity()
                                 : Vec3((position - reported_) / model_.tick_seconds);
    reported_ = position;
    reading.sample = tick_ + 1;
    return reading;
}

/// Where the person wants the tip.
Vec3 SelfTestHand::target() noexcept
{
    const auto swing = [&](double hertz) { return std::sin(full_turn * hertz * seconds_); };
    switch (step_) {
    case SelfTestStep::slow:
        return middle + Vec3(0.01 * swing(0.3), 0.008 * swing(0.37), 0.009 * swing(0.23));
    case SelfTestStep::fast:
        return middle + Vec3(0.03 * swing(2), 0.03 * swing(1.7), 0.025 * swing(2.3));
    default:
        return middle;
    }
}

void SelfTestHand::write(const DeviceCommand& command) noexcept
{
    if (test_ != nullptr) {
        const SelfTestStep now = test_->step();
        seconds_ = now == step_ ? seconds_ + model_.tick_seconds : 0;
        step_ = now;
        const bool hands_off =
            step_ > SelfTestStep::release ||
            (step_ == SelfTestStep::release && !test_->prepares() && seconds_ > let_go_after);
        if (hands_off && holds_) {
            free_.set_motion(holding_.position(), holding_.velocity());
            holds_ = false;
        }
    }
    const std::size_t slots = static_cast<std::size_t>(model_.delay_ticks) + 1;
    delayed_[tick_ % slots] = command.force;
    ++tick_;
    const Vec3 felt = delayed_[tick_ % slots];
    const Vec3 wanted = target();
    for (int part = 0; part < parts; ++part) (holds_ ? holding_ : free_).step(felt, wanted);
}

} // namespace proxima
