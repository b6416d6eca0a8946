// The simulated hand (simulated_hand.h) that is pulled somewhere, by a script or by a mouse, as a
// device.
#pragma once

#include "lab/simulated_hand.h"
#include "proxima/device.h"

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

namespace proxima {

/// Where a hand wants to go, m, at a time of the session, s. Called by the device's thread in every
/// tick: must neither throw nor allocate.
using HandTarget = std::function<Vec3(double seconds)>;

/// Each tick is one of the hand's model, whatever the clock says: the same forces paced or not.
class HandDevice final : public Device {
public:
    /// At rest at `start`. \pre as SimulatedHand, and there is a target
    HandDevice(std::string name, const HandModel& model, HandTarget target, const Vec3& start,
               const DeviceLimits& limits)
        : target_(std::move(target)), hand_(model, start)
    {
        info_.name = std::move(name);
        info_.model = "a simulated hand";
        info_.limits = limits;
        info_.pushes = false;
        info_.stillness = Stillness::usual;
    }

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    [[nodiscard]] const SimulatedHand& hand() const noexcept { return hand_; }

    [[nodiscard]] DeviceReading read() noexcept override { return {hand_.state(), tick_ + 1}; }

    void write(const DeviceCommand& command) noexcept override
    {
        const double seconds = static_cast<double>(tick_++) * hand_.model().tick_seconds;
        hand_.step(command.force, target_(seconds));
    }

private:
    HandTarget target_;
    SimulatedHand hand_;
    DeviceInfo info_;
    std::uint64_t tick_ = 0;
};

} // namespace proxima
