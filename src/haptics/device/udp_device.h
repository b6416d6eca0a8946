// A device in another program, over UDP (udp_packets.h): its servo loop sends a state and gets a
// reply for each, as fast as it likes; ours reads the newest every tick.
//
//     proxima touch bunny.obj --device udp:4711         listens on this machine alone
//
// Datagrams are not trusted. A tick takes at most 64 of them. It accepts only whole ones of our
// version, from one device at a time (the address and session of the first, until it leaves or is silent
// for a second), only samples newer than the last by at most 65,536, and only if their delay exceeds the
// shortest by no more than the patience. After a second without a good one the same device may start
// anew with any number. Their content goes through DeviceInput like that of every device. After the
// patience (20 ms) without a good one the force fades within ForceOptions::loss_seconds (50 ms).
#pragma once

#include "base/udp_socket.h"
#include "haptics/device/packet_sequence.h"
#include "haptics/device/udp_packets.h"
#include "proxima/device.h"

#include <cstdint>
#include <memory>

namespace proxima {

struct UdpOptions {
    UdpAddress address; ///< where to listen
    DeviceLimits limits = *find_device("omni");
    double patience = 0.02;         ///< s without a good packet, until the device is silent
    double fade_seconds = 0.05;     ///< sent to the device: time in which forces fade there
    double recovery_seconds = 0.01; ///< sent to the device: time of crossing over to new planes
    double forget_seconds = 1;      ///< silence after which another device may come
};

/// Counts of datagrams.
struct UdpReport {
    std::uint64_t received = 0;
    std::uint64_t accepted = 0;
    std::uint64_t malformed = 0;  ///< of a wrong size, magic or version
    std::uint64_t foreign = 0;    ///< of another device than the served one
    std::uint64_t duplicated = 0; ///< with the number of the last one
    std::uint64_t reordered = 0;  ///< with a lower number
    std::uint64_t leapt = 0;      ///< with a number that is too high to follow
    std::uint64_t lost = 0;       ///< missing numbers, in each session from its first
    std::uint64_t late = 0;       ///< delayed too long
    std::uint64_t sessions = 0;   ///< of devices, one after another
    std::uint64_t replies = 0;
    std::uint64_t unsent = 0; ///< replies that the system refused
};

/// The device. Clocks: CLOCK_MONOTONIC here, any there.
class UdpDevice final : public Device {
public:
    /// Errors: those of UdpSocket::listen.
    [[nodiscard]] static Result<std::unique_ptr<UdpDevice>> open(const UdpOptions& options);
    ~UdpDevice() override;

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    [[nodiscard]] DeviceReading read() noexcept override;
    void write(const DeviceCommand& command) noexcept override;

    [[nodiscard]] UdpAddress address() const noexcept { return socket_.address(); }
    [[nodiscard]] const UdpReport& report() const noexcept { return report_; }
    [[nodiscard]] std::string trouble() const override;

    /// Handles a datagram that came at a time, ns, as read() does those of the socket. noexcept, any
    /// bytes.
    void take(std::span<const std::byte> datagram, const UdpAddress& from,
              std::int64_t nanoseconds) noexcept;

private:
    UdpDevice(UdpSocket socket, const UdpOptions& options);
    [[nodiscard]] bool is_in_time(const StatePacket& packet, std::int64_t nanoseconds) noexcept;

    UdpSocket socket_;
    UdpOptions options_;
    DeviceInfo info_;
    UdpReport report_;
    DeviceReading reading_;
    PacketSequence order_;
    StatePacket answered_; ///< the state that the next reply answers
    double quickest_ = 0;  ///< ns: the least difference of the clocks, arrival less stamp
    std::int64_t quickest_at_ = 0;
    bool unanswered_ = false;
};

} // namespace proxima
