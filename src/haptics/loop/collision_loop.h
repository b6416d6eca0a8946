// The collision loop (thesis 5.1): a hundred times a second it makes the patch that the servo loop
// touches until the next one comes.
//
//     servo loop   1,000 Hz   sends positions of device and proxy   ──snapshot──▶  collision loop
//                             touches the latest patch              ◀──snapshot──  100 Hz
//
// Both pass values through a Snapshot, so neither waits for the other. If no patch comes in time,
// the patch is lost: the force fades (contact_force.h) until there is a new one.
#pragma once

#include "haptics/loop/snapshot.h"
#include "haptics/surface/contact_patch.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/device.h"

#include <atomic>
#include <cstdint>
#include <thread>

namespace proxima {

/// Positions that the servo loop sends.
struct ServoPosition {
    Vec3 device = Vec3::Zero(); ///< in the model's units
    Vec3 proxy = Vec3::Zero();
    std::uint64_t tick = 0;
};

struct CollisionOptions {
    double rate = 100;             ///< patches per second
    double latency_seconds = 0.01; ///< from a sent position to a patch in use, beyond the period
    double speed = 1;              ///< of the fastest hand, in the model's units per second
    double proxy_radius = 0;       ///< in the model's units
};

/// Both hand-overs. The servo thread calls send_position() and latest_patch(), the collision thread
/// the others. All are wait-free, without allocation.
class PatchExchange {
public:
    PatchExchange() = default;
    /// Patches have a capacity of so many triangles.
    explicit PatchExchange(std::size_t triangles) : patches_(ContactPatch(triangles)) {}

    void send_position(const ServoPosition& position) noexcept
    {
        positions_.writing() = position;
        positions_.publish();
    }
    /// The newest patch; null before the first.
    [[nodiscard]] const ContactPatch* latest_patch() noexcept
    {
        has_patch_ = patches_.update() || has_patch_;
        return has_patch_ ? &patches_.reading() : nullptr;
    }
    /// Takes the newest position. False where none was sent since the last call.
    [[nodiscard]] bool receive_position(ServoPosition& position) noexcept
    {
        if (!positions_.update()) return false;
        position = positions_.reading();
        return true;
    }
    /// The patch to be filled, and then published.
    [[nodiscard]] ContactPatch& writing() noexcept { return patches_.writing(); }
    void publish_patch() noexcept { patches_.publish(); }

private:
    Snapshot<ServoPosition> positions_;
    Snapshot<ContactPatch> patches_;
    bool has_patch_ = false; ///< the servo thread's
};

/// Makes the metric patch for a position. It refers to the surface, which must outlive it.
void make_patch(ContactPatch& patch, const IndexContactSurface& surface,
                const ServoPosition& position, const CollisionOptions& options) noexcept;

/// Runs in a thread of its own from construction to destruction.
class CollisionLoop {
public:
    /// Refers to surface and exchange, which must outlive it; the surface must also outlive every
    /// patch in use, including those in the exchange.
    CollisionLoop(const IndexContactSurface& surface, PatchExchange& exchange,
                  const CollisionOptions& options);
    CollisionLoop(const CollisionLoop&) = delete;
    CollisionLoop& operator=(const CollisionLoop&) = delete;
    /// Ends the thread within a period.
    ~CollisionLoop();

    /// Ends the thread and returns its statistics.
    [[nodiscard]] const ServoStatistics& stop();

    [[nodiscard]] std::uint64_t patches() const noexcept { return patches_.load(); }

private:
    std::atomic<bool> ending_{false};
    std::atomic<std::uint64_t> patches_{0};
    ServoStatistics statistics_;
    std::thread thread_;
};

} // namespace proxima
