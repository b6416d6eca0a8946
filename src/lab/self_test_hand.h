// A simulated person who does what a self-test says, with a simulated device.
//
//     slow      moves it to and fro along all axes, at 10 to 20 mm/s
//     fast      moves it in loops, at up to 0.4 m/s
//     release   brings it to the middle, and lets go after a second
//     then      keeps the hands off
//
// Between ticks the motion is computed in ten parts, so that friction stops the device when it should
// and not at the end of a tick.
#pragma once

#include "haptics/device/self_test.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"

#include <array>
#include <string>
#include <utility>

namespace proxima {

/// A device whose time is its ticks: each is one of the model's.
class SelfTestHand final : public Device {
public:
    /// \pre as SimulatedHand
    SelfTestHand(std::string name, const HandModel& model, const DeviceLimits& limits);

    /// The person listens to this test, which must outlive the device's last tick.
    void follow(const SelfTest& test) noexcept { test_ = &test; }

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    [[nodiscard]] const HandModel& model() const noexcept { return model_; }
    [[nodiscard]] DeviceReading read() noexcept override;
    void write(const DeviceCommand& command) noexcept override;

private:
    static constexpr int parts = 10; ///< of a tick

    [[nodiscard]] static HandModel part_of(HandModel model) noexcept;
    [[nodiscard]] static HandModel released(HandModel model) noexcept;
    [[nodiscard]] Vec3 target() noexcept;

    HandModel model_;
    SimulatedHand holding_;
    SimulatedHand free_;
    bool holds_ = true;
    DeviceInfo info_;
    const SelfTest* test_ = nullptr;
    SelfTestStep step_ = SelfTestStep::waiting;
    double seconds_ = 0; ///< of the step
    Vec3 reported_ = Vec3::Zero();
    std::array<Vec3, max_hand_delay + 1> delayed_;
    std::uint64_t tick_ = 0;
};

} // namespace proxima
