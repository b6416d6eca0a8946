// A device in another program, over UDP (udp_packets.h): its servo loop sends a state and gets a
// reply for each, as fast as it likes; ours reads the newest every tick.
//
//     proxima touch bunny.obj --device udp:4711         listens on this machine alone
//
// Nothing of what comes is trusted. A tick takes at most 64 datagrams; only whole ones of our
// version count, only of one device at a time (the first one's address and session, until it was
// silent for a second), only newer samples than the last, though no more than 65,536 newer, and
// only such that were not longer on the way than the quickest by more than the patience. After a
// second in which none was good the same device may begin anew with any number. What they say goes
// through DeviceInput like every device's. After the patience (20 ms) without a good one the force
// fades within ForceOptions::loss_seconds (50 ms).
#pragma once

#include "base/udp_socket.h"
#include "haptics/device/udp_packets.h"
#include "proxima/device.h"

#include <cstdint>
#include <memory>

namespace proxima {

struct UdpOptions {
    UdpAddress address; ///< where to listen
    DeviceLimits limits = *find_device("omni");
    double patience = 0.02;         ///< s without a good packet, until the device is silent
    double fade_seconds = 0.05;     ///< told to the device: in which forces fade there
    double recovery_seconds = 0.01; ///< told to the device: in which it goes over to new planes
    double forget_seconds = 1;      ///< silence after which another device may come
};

/// Datagrams, by what became of them.
struct UdpReport {
    std::uint64_t received = 0;
    std::uint64_t accepted = 0;
    std::uint64_t malformed = 0;  ///< of a wrong size, magic or version
    std::uint64_t foreign = 0;    ///< of another device than the one that is served
    std::uint64_t duplicated = 0; ///< with the number of the last one
    std::uint64_t reordered = 0;  ///< with a lower number
    std::uint64_t leapt = 0;      ///< with a number that is too high to follow
    std::uint64_t lost = 0;       ///< numbers left out, of each session from its first
    std::uint64_t late = 0;       ///< too long on the way
    std::uint64_t sessions = 0;   ///< devices served, one after another, and begun anew
    std::uint64_t replies = 0;
    std::uint64_t unsent = 0; ///< replies that the system did not take
};

/// The device. Clocks: CLOCK_MONOTONIC here, any there.
class UdpDevice final : public Device {
public:
    /// Errors: those of UdpSocket::listen.
    [[nodiscard]] static Result<std::unique_ptr<UdpDevice>> open(const UdpOptions& options);

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    [[nodiscard]] DeviceReading read() noexcept override;
    void write(const DeviceCommand& command) noexcept override;

    [[nodiscard]] UdpAddress address() const noexcept { return socket_.address(); }
    [[nodiscard]] const UdpReport& report() const noexcept { return report_; }
    [[nodiscard]] std::string trouble() const override;

    /// What becomes of a datagram that came at a time, ns: as read() does it with the socket's.
    /// noexcept, any bytes.
    void take(std::span<const std::byte> datagram, const UdpAddress& from,
              std::int64_t nanoseconds) noexcept;

private:
    UdpDevice(UdpSocket socket, const UdpOptions& options);
    [[nodiscard]] bool is_served(const StatePacket& packet, const UdpAddress& from,
                                 std::int64_t nanoseconds) noexcept;
    [[nodiscard]] bool is_in_time(const StatePacket& packet, std::int64_t nanoseconds) noexcept;

    UdpSocket socket_;
    UdpOptions options_;
    DeviceInfo info_;
    UdpReport report_;
    DeviceReading reading_;
    StatePacket last_;
    UdpAddress peer_;
    std::int64_t last_heard_ = 0;
    double quickest_ = 0; ///< ns: the least difference of the clocks, arrival less stamp
    std::int64_t quickest_at_ = 0;
    bool served_ = false; ///< there is a device
    bool first_ = true;   ///< of which nothing was accepted yet
    bool unanswered_ = false;
};

} // namespace proxima
