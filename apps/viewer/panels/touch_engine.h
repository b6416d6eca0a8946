// A model that is touched by a device, real or simulated, in a servo loop of its own thread;
// whoever draws reads the latest moment.
//
//     device ──▶ DeviceInput ──▶ HapticRenderer ──▶ force ──▶ device
//                                      │
//     picture ◀── Snapshot<TouchMoment>┘
#pragma once

#include "cli/touch_device.h"
#include "haptics/loop/snapshot.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace proxima {

/// What a picture shows of a touch. Positions in the model's units, forces in newtons.
struct TouchMoment {
    static constexpr std::size_t history = 400;

    Vec3 device = Vec3::Zero();
    Vec3 proxy = Vec3::Zero();
    Vec3 force = Vec3::Zero();
    Hold hold = Hold::free;
    InputCondition condition = InputCondition::silent;
    bool placed = false; ///< the device has reported a position
    std::uint32_t buttons = 0;
    double rate = 0;           ///< ticks per second, of the last half second
    double worst_interval = 0; ///< s between two ticks, of the last half second
    std::uint64_t ticks = 0;
    std::array<float, history> forces{}; ///< N, one of every five ticks, the oldest first
};

struct TouchOptions {
    double stiffness = 400;
    double damping = 1;
    double static_friction = 0.4;
    double dynamic_friction = 0.3;
    Mat3 axes = Mat3::Identity(); ///< from the device's to the model's
};

/// Device and renderer, tick by tick. The surface must outlive it.
class TouchSession {
public:
    TouchSession(const ContactSurface& surface, TouchDevice device, const TouchOptions& options);

    /// One millisecond on: reads, renders, writes. noexcept, without allocation.
    void tick() noexcept;

    /// From the next tick on the force fades.
    void release() noexcept { input_.release(); }

    [[nodiscard]] Device& device() noexcept { return *device_.device; }
    [[nodiscard]] const TouchMoment& moment() const noexcept { return moment_; }
    [[nodiscard]] TouchMoment& moment() noexcept { return moment_; }

    static constexpr double tick_seconds = 1e-3;

private:
    TouchDevice device_;
    DeviceInput input_;
    HapticRenderer renderer_;
    TouchMoment moment_;
};

/// Opens a device: may take a second.
using OpenTouchDevice = std::function<Result<TouchDevice>()>;

/// What became of the device.
struct TouchDeviceState {
    std::string words;   ///< whose it is; "" while it is being opened, and where it is not there
    std::string problem; ///< why it is not there, or what ended it; "" for nothing
};

/// A session in real time, in a thread that opens the device and closes it, until destroyed. The
/// surface must outlive it.
class TouchEngine {
public:
    TouchEngine(const ContactSurface& surface, OpenTouchDevice open, const TouchOptions& options);
    TouchEngine(const TouchEngine&) = delete;
    TouchEngine& operator=(const TouchEngine&) = delete;
    /// Lets the force fade, closes the device, waits for both.
    ~TouchEngine();

    /// The latest moment.
    [[nodiscard]] const TouchMoment& moment();
    [[nodiscard]] TouchDeviceState device() const;

private:
    void run(const ContactSurface& surface, const OpenTouchDevice& open,
             const TouchOptions& options);
    void say(TouchDeviceState state);

    Snapshot<TouchMoment> moments_;
    mutable std::mutex mutex_;
    TouchDeviceState state_;
    std::atomic<bool> stops_{false};
    std::thread thread_; // last: uses what is above
};

} // namespace proxima
