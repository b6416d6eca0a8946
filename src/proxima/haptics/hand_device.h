// The simulated hand (simulated_hand.h) that follows a script, as a device.
#pragma once

#include "proxima/haptics/device.h"
#include "proxima/haptics/hand_script.h"
#include "proxima/haptics/simulated_hand.h"

namespace proxima {

/// Each tick is one of the hand's model, whatever the clock says: the same forces paced or not.
class HandDevice final : public Device {
public:
    HandDevice(const HandModel& model, HandScript script, const DeviceLimits& limits)
        : script_(std::move(script)), hand_(model, script_.target(0))
    {
        info_.name = "hand";
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
        hand_.step(command.force, script_.target(seconds));
    }

private:
    HandScript script_;
    SimulatedHand hand_;
    DeviceInfo info_;
    std::uint64_t tick_ = 0;
};

} // namespace proxima
