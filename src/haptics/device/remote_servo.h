// The servo loop at the other end of a slow or lossy connection: makes the force from the planes of
// the last reply, a thousand times a second, however seldom replies come.
//
//     reply         planes, K, B, friction ──▶ anchor ──▶ spring and damper
//     new planes    the force crosses over to them within recovery_seconds ([mark-1996])
//     no reply      lasts for hold_seconds, then fades within fade_seconds; comes back as slowly
//
// Forces are finite and within the limits of device and reply, whatever replies contain.
#pragma once

#include "haptics/device/udp_packets.h"
#include "proxima/device.h"

namespace proxima {

/// One thread. noexcept, no allocation. Times are seconds of any monotonic clock.
class RemoteServo {
public:
    /// \pre max_force > 0, N: the device's limit, whatever a reply allows
    explicit RemoteServo(double max_force) noexcept;

    /// Takes a reply. One with a number that is not finite, or that answers an older state than the
    /// last, is refused.
    void take(const ReplyPacket& reply, double now) noexcept;

    /// The force for the tip, N.
    [[nodiscard]] Vec3 force(const Vec3& position, const Vec3& velocity, double now) noexcept;

    /// The part of the force that is given: 1 while replies come.
    [[nodiscard]] double fade_factor() const noexcept { return fade_factor_; }
    [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; } ///< replies

private:
    double max_force_;
    ReplyPacket reply_;
    bool received_ = false;
    bool switched_ = false; ///< a reply came since the last force
    double received_at_ = 0;
    double switched_at_ = 0;
    double last_now_ = 0;
    double fade_factor_ = 0;
    DeviceCommand used_;             ///< by the last force
    Vec3 difference_ = Vec3::Zero(); ///< force of the planes before less that of the new ones
    std::uint64_t refused_ = 0;
};

} // namespace proxima
