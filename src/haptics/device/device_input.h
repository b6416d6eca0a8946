// Between a device and the renderer: accepts only input that a hand can produce, turns the device's
// axes, lets the user re-grip, and hands button events over.
//
//     device.read() ─▶ watch ─▶ turn, clutch ─▶ renderer.tick() ─▶ turn back ─▶ device.write()
//                        │            │
//                   InputReport  ButtonQueue
//
//     DeviceInput input(device.info());
//     const RenderTick& felt = renderer.tick(input.accept(device.read()), 1e-3);
//     device.write(input.command(renderer));
//
// Input that is not plausible is replaced by the last good position, with a condition that lets the
// force fade (ForceOptions::loss_seconds). Once the device is well the force comes back as slowly.
// What comes out is all that the renderer sees: recordings hold it, and replay the same bits.
//
//     not a number, or metres away          unsure    until there is a good sample
//     a jump that no hand makes             unsure    until settle_seconds of samples agree on the
//                                                     new place
//     the same bits while pushed            frozen    until they change
//     nothing new                           silent    after DeviceInfo::patience
//     the driver says so                    gone
//     the clutch button                     clutched  the device moves, what it holds does not
//
// A velocity that the places do not bear out (velocity_bounds.h) is replaced by one of their
// differences, and nothing fades.
#pragma once

#include "haptics/device/button_queue.h"
#include "haptics/device/velocity_bounds.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <cstdint>

namespace proxima {

struct InputOptions {
    double tick_seconds = 1e-3;
    double max_jump = 0.05;           ///< m between two samples: 50 m/s at 1 kHz
    double max_distance = 10;         ///< m from the device's middle: farther is no place
    double settle_seconds = 0.1;      ///< of samples that agree, before a jump is accepted
    double frozen_seconds = 0.5;      ///< of the same bits, before a pushed device counts as frozen
    double frozen_force = 0.05;       ///< N: less does not push it
    Mat3 rotation = Mat3::Identity(); ///< from the device's axes to ours: a rotation
    std::uint32_t clutch_buttons = 0; ///< bits: while one of them is pressed, the clutch is open
};

/// What was wrong with a session's input, counted.
struct InputReport {
    std::uint64_t samples = 0;        ///< that were new
    std::uint64_t not_finite = 0;     ///< samples that were no place
    std::uint64_t jumps = 0;          ///< that no hand makes
    std::uint64_t velocities = 0;     ///< samples whose velocity the places did not bear out
    std::uint64_t freezes = 0;        ///< times that it froze while pushed
    std::uint64_t silences = 0;       ///< times that nothing came for longer than its patience
    std::uint64_t losses = 0;         ///< times that the driver said it was gone
    std::uint64_t faulty_ticks = 0;   ///< ticks that were not well, clutch and release apart
    std::uint64_t clutched_ticks = 0; ///< with an open clutch
    double longest_fault = 0;         ///< s: from the first faulty tick to the last
    std::uint64_t recoveries = 0;     ///< times that it was well again with the whole force
    double longest_recovery = 0;      ///< s: from the first good tick to the whole force
};

/// One per device; the servo thread's, but for the queue's other end. noexcept, no allocation, no
/// lock, O(1).
class DeviceInput {
public:
    /// \pre tick_seconds > 0, the rotation is one
    explicit DeviceInput(const DeviceInfo& info, const InputOptions& options = {}) noexcept;

    /// What the renderer is to use in this tick. Before the first good sample the position is
    /// no number, which the renderer takes as nothing to touch.
    const DeviceState& accept(const DeviceReading& reading) noexcept;

    /// What the device gets, in its own axes, after the renderer's tick.
    [[nodiscard]] DeviceCommand command(const HapticRenderer& renderer) noexcept;

    /// From the next tick on the force fades for good: the session ends.
    void release() noexcept { released_ = true; }

    /// Press and release of every button, in order. One thread pops.
    [[nodiscard]] ButtonQueue& buttons() noexcept { return events_; }

    [[nodiscard]] const InputReport& report() const noexcept { return report_; }
    [[nodiscard]] const DeviceState& state() const noexcept { return state_; }

private:
    [[nodiscard]] InputCondition condition_of(const DeviceReading& reading) noexcept;
    [[nodiscard]] InputCondition judge(const DeviceState& said) noexcept;
    [[nodiscard]] bool same_as_before(const DeviceState& said) const noexcept;
    [[nodiscard]] Vec3 velocity_of(const DeviceState& said) noexcept;
    void count_buttons(std::uint32_t buttons) noexcept;
    void count(InputCondition condition) noexcept;
    void watch_recovery(double trust) noexcept;

    ButtonQueue events_;
    InputOptions options_;
    double patience_;
    DeviceState state_; ///< as given to the renderer
    VelocityBounds bounds_;
    std::uint64_t sampled_ = 0;     ///< tick of the last good sample
    Vec3 good_ = Vec3::Zero();      ///< the device's last good place, in its axes
    Vec3 offset_ = Vec3::Zero();    ///< of the clutch
    Vec3 jumped_to_ = Vec3::Zero(); ///< where samples are that are not accepted
    double agreed_ = 0;             ///< s: for how long they agree
    double unchanged_ = 0;          ///< s: of the same bits while pushed
    double waited_ = 0;             ///< s: since the last new sample
    double force_ = 0;              ///< N: of the last tick
    std::uint64_t sample_ = 0;
    std::uint64_t tick_ = 0;
    DeviceState last_said_;
    double fault_ = 0;       ///< s: of the fault in progress
    double recovering_ = -1; ///< s: since it is well again; negative where it never was unwell
    InputReport report_;
    std::uint32_t buttons_ = 0;
    bool may_rest_;
    bool placed_ = false;
    bool jumping_ = false;
    bool released_ = false;
    bool heard_ = false;
};

} // namespace proxima
