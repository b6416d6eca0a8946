// A model that is touched: a simulated hand pulls a device to where the mouse wants it, in a servo
// loop of its own thread; whoever draws reads the latest moment.
//
//     mouse ──target──> Snapshot ──> hand ──> device ──> HapticRenderer ──> force
//     picture <── moment ── Snapshot <──────────────────────────┘
#pragma once

#include "proxima/haptics/contact_surface.h"
#include "proxima/haptics/haptic_renderer.h"
#include "proxima/haptics/simulated_hand.h"
#include "proxima/haptics/snapshot.h"

#include <array>
#include <atomic>
#include <memory>
#include <thread>

namespace proxima {

/// What a picture shows of a touch. Places in the model's units, forces in newtons.
struct TouchMoment {
    static constexpr std::size_t history = 400;

    Vec3 device = Vec3::Zero();
    Vec3 proxy = Vec3::Zero();
    Vec3 force = Vec3::Zero();
    Hold hold = Hold::free;
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
};

/// The hand and the renderer, tick by tick. noexcept and without allocation but for the
/// constructor.
class TouchSimulation {
public:
    /// The hand begins at `start`, in the model's units.
    TouchSimulation(const ContactSurface& surface, const Box& bounds, const TouchOptions& options,
                    const Vec3& start);

    /// One millisecond on.
    void tick(const Vec3& target) noexcept;

    [[nodiscard]] const TouchMoment& moment() const noexcept { return moment_; }
    [[nodiscard]] TouchMoment& moment() noexcept { return moment_; }
    [[nodiscard]] const WorkspaceMap& map() const noexcept { return map_; }

    static constexpr double tick_seconds = 1e-3;

private:
    WorkspaceMap map_;
    HapticRenderer renderer_;
    SimulatedHand hand_;
    TouchMoment moment_;
};

/// The simulation in real time, until destroyed. The surface must outlive it.
class TouchEngine {
public:
    TouchEngine(const ContactSurface& surface, const Box& bounds, const TouchOptions& options,
                const Vec3& start);
    TouchEngine(const TouchEngine&) = delete;
    TouchEngine& operator=(const TouchEngine&) = delete;
    ~TouchEngine();

    /// Where the mouse wants the device.
    void pull_to(const Vec3& target);

    /// The latest moment.
    [[nodiscard]] const TouchMoment& moment();

private:
    void run() noexcept;

    TouchSimulation simulation_;
    Snapshot<Vec3> target_;
    Snapshot<TouchMoment> moments_;
    std::atomic<bool> stops_{false};
    std::thread thread_; // last: uses what is above
};

} // namespace proxima
