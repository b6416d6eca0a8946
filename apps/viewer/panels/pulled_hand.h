// The hand of somebody who has a mouse and no device: a simulated hand (simulated_hand.h) that
// follows a target, as a device.
#pragma once

#include "proxima/haptics/device.h"
#include "proxima/haptics/simulated_hand.h"
#include "proxima/haptics/snapshot.h"

#include <memory>
#include <utility>

namespace proxima {

/// Where the hand wants to go, in metres of the device: from one thread to the device's.
using HandTarget = Snapshot<Vec3>;

/// Each tick is one of the hand's model, whatever the clock says: the same forces paced or not.
class PulledHand final : public Device {
public:
    /// At rest at `start`.
    PulledHand(std::shared_ptr<HandTarget> target, const DeviceLimits& limits,
               const HandModel& model, const Vec3& start)
        : target_(std::move(target)), hand_(model, start)
    {
        info_.name = "mouse";
        info_.model = "a simulated hand";
        info_.limits = limits;
        info_.pushes = false;
        info_.stillness = Stillness::usual;
    }

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }

    [[nodiscard]] DeviceReading read() noexcept override { return {hand_.state(), tick_ + 1}; }

    void write(const DeviceCommand& command) noexcept override
    {
        ++tick_;
        target_->update();
        hand_.step(command.force, target_->reading());
    }

private:
    std::shared_ptr<HandTarget> target_;
    SimulatedHand hand_;
    DeviceInfo info_;
    std::uint64_t tick_ = 0;
};

} // namespace proxima
