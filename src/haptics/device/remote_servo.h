// The servo loop on the other side of a slow or lossy line: makes the force from the planes of the
// last reply, a thousand times a second, however seldom replies come.
//
//     reply   planes, K, B, friction ──▶ anchor ──▶ spring and damper
//     new planes    the force goes over to them within recovery_seconds ([mark-1996])
//     no reply      holds for hold_seconds, then fades within fade_seconds; comes back as slowly
//
// What it gives is finite, no longer than the device's and the reply's limit, whatever replies
// hold.
#pragma once

#include "haptics/device/udp_packets.h"
#include "proxima/device.h"

namespace proxima {

/// One thread. noexcept, no allocation. Times are seconds of any one clock that does not go back.
class RemoteServo {
public:
    /// \pre max_force > 0, N: of the device, whatever a reply allows
    explicit RemoteServo(double max_force) noexcept;

    /// A reply came. One with a number that is not finite is left out, and so is one that answers
    /// an older state than the last.
    void take(const ReplyPacket& reply, double now) noexcept;

    /// The force for the tip, N.
    [[nodiscard]] Vec3 force(const Vec3& position, const Vec3& velocity, double now) noexcept;

    /// How much of the force is given: 1 while replies come.
    [[nodiscard]] double trust() const noexcept { return trust_; }
    [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; } ///< replies left out

private:
    double max_force_;
    ReplyPacket reply_;
    bool heard_ = false;
    bool switched_ = false; ///< a reply came since the last force
    double heard_at_ = 0;
    double switched_at_ = 0;
    double last_now_ = 0;
    double trust_ = 0;
    DeviceCommand used_;             ///< by the last force
    Vec3 difference_ = Vec3::Zero(); ///< of the planes' force before from the one after
    std::uint64_t refused_ = 0;
};

} // namespace proxima
