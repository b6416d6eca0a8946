// The collision loop (thesis 5.1): a hundred times a second it makes the patch that the servo loop
// touches until the next one comes.
//
//     servo loop   1,000 Hz   says where device and proxy are   ──snapshot──▶  collision loop
//                             touches the latest patch          ◀──snapshot──  100 Hz
//
// Both hand over by Snapshot: neither ever waits for the other. A patch that does not come in time
// is lost: the force fades (contact_force.h) until one is there again.
#pragma once

#include "haptics/loop/snapshot.h"
#include "haptics/surface/contact_patch.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/device.h"

#include <atomic>
#include <cstdint>
#include <thread>

namespace proxima {

/// What the servo loop says.
struct ServoPlace {
    Vec3 device = Vec3::Zero(); ///< in the model's units
    Vec3 proxy = Vec3::Zero();
    std::uint64_t tick = 0;
};

struct CollisionOptions {
    double rate = 100;             ///< patches per second
    double latency_seconds = 0.01; ///< from the servo's word to a patch in use, beyond the period
    double speed = 1;              ///< of the fastest hand, in the model's units per second
    double proxy_radius = 0;       ///< in the model's units
};

/// The two hand-overs. The servo thread calls say() and take(), the collision thread hear() and
/// give(): each wait-free, without allocation.
class PatchExchange {
public:
    PatchExchange() = default;
    /// Patches have room for so many triangles.
    explicit PatchExchange(std::size_t triangles) : patches_(ContactPatch(triangles)) {}

    void say(const ServoPlace& place) noexcept
    {
        places_.writing() = place;
        places_.publish();
    }
    /// The newest patch; nothing before the first.
    [[nodiscard]] const ContactPatch* take() noexcept
    {
        has_patch_ = patches_.update() || has_patch_;
        return has_patch_ ? &patches_.reading() : nullptr;
    }
    /// True where the servo has spoken since the last time.
    [[nodiscard]] bool hear(ServoPlace& place) noexcept
    {
        if (!places_.update()) return false;
        place = places_.reading();
        return true;
    }
    [[nodiscard]] ContactPatch& writing() noexcept { return patches_.writing(); }
    void give() noexcept { patches_.publish(); }

private:
    Snapshot<ServoPlace> places_;
    Snapshot<ContactPatch> patches_;
    bool has_patch_ = false; ///< the servo thread's
};

/// Makes the metric patch for a place. It refers to the surface, which must outlive it.
void make_patch(ContactPatch& patch, const IndexContactSurface& surface, const ServoPlace& place,
                const CollisionOptions& options) noexcept;

/// Runs in a thread of its own from construction to destruction.
class CollisionLoop {
public:
    /// Refers to surface and exchange, which must outlive it; the surface also every patch that is
    /// still touched, those in the exchange among them.
    CollisionLoop(const IndexContactSurface& surface, PatchExchange& exchange,
                  const CollisionOptions& options);
    CollisionLoop(const CollisionLoop&) = delete;
    CollisionLoop& operator=(const CollisionLoop&) = delete;
    /// Ends the thread: within a period.
    ~CollisionLoop();

    /// Ends the thread and says what it did.
    [[nodiscard]] const ServoStatistics& stop();

    [[nodiscard]] std::uint64_t patches() const noexcept { return patches_.load(); }

private:
    std::atomic<bool> ending_{false};
    std::atomic<std::uint64_t> patches_{0};
    ServoStatistics statistics_;
    std::thread thread_;
};

} // namespace proxima
