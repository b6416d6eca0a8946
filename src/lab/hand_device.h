// A device that a simulated hand (simulated_hand.h) holds, which a script or a mouse pulls to a
// target.
#pragma once

#include "lab/simulated_hand.h"
#include "proxima/device.h"

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

namespace proxima {

/// The target of a hand, m, at a time of the session, s. The device's thread calls it in every tick:
/// it must neither throw nor allocate.
using HandTarget = std::function<Vec3(double seconds)>;

/// Each tick is one of the hand's model, whatever the clock: forces are the same paced or not.
class HandDevice final : public Device {
public:
    /// At rest at `start`. \pre as SimulatedHand; target is not empty
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
