// Hands patches from the collision loop to the servo loop (thesis 5.1), and positions back.
//
//     servo loop   1,000 Hz   sends positions of device and proxy   ──snapshot──▶  collision loop
//                             touches the latest patch              ◀──snapshot──  100 Hz
//
// Both pass values through a Snapshot, so neither waits for the other. If no patch comes in time,
// the patch is lost: the force fades (contact_force.h) until there is a new one.
#pragma once

#include "haptics/loop/snapshot.h"
#include "haptics/surface/contact_patch.h"
#include "proxima/geometry.h"

#include <cstdint>

namespace proxima {

/// Positions that the servo loop sends.
struct ServoPosition {
    Vec3 device = Vec3::Zero(); ///< in the model's units
    Vec3 proxy = Vec3::Zero();
    std::uint64_t tick = 0;
};

/// Both hand-overs. The servo thread calls send_position() and latest_patch(), the collision thread
/// the others. All are wait-free, without allocation.
class PatchExchange {
public:
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

} // namespace proxima
