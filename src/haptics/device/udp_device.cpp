#include "haptics/device/udp_device.h"

#include "base/text.h"

#include <algorithm>
#include <array>
#include <ctime>

namespace proxima {

namespace {

constexpr int datagrams_per_tick = 64;

/// The relative drift of two clocks: at most a tenth of a per mille.
constexpr double clock_drift = 1e-4;

std::int64_t clock_now() noexcept
{
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * 1'000'000'000 + time.tv_nsec;
}

} // namespace

Result<std::unique_ptr<UdpDevice>> UdpDevice::open(const UdpOptions& options)
{
    auto socket = UdpSocket::listen(options.address);
    if (!socket) return tl::unexpected(socket.error());
    return std::unique_ptr<UdpDevice>(new UdpDevice(std::move(*socket), options));
}

UdpDevice::UdpDevice(UdpSocket socket, const UdpOptions& options)
    : socket_(std::move(socket)), options_(options),
      order_(options.patience, options.forget_seconds)
{
    info_.name = concat("udp:", to_text(socket_.address()));
    info_.model = "a program over UDP";
    info_.limits = options.limits;
    info_.buttons = 32;
    info_.rotates = true;
    info_.patience = options.patience;
}

bool UdpDevice::is_in_time(const StatePacket& packet, std::int64_t nanoseconds) noexcept
{
    // In doubles, for stamps may be any numbers.
    const double difference =
        static_cast<double>(nanoseconds) - static_cast<double>(packet.nanoseconds);
    const auto passed = static_cast<double>(nanoseconds - quickest_at_);
    // If all are late, their clock was set back.
    const bool anew =
        order_.is_first() ||
        1e-9 * static_cast<double>(nanoseconds - order_.last_heard()) > options_.forget_seconds;
    if (anew || difference < quickest_ + clock_drift * passed) {
        quickest_ = difference;
        quickest_at_ = nanoseconds;
        return true;
    }
    return difference - (quickest_ + clock_drift * passed) <= 1e9 * options_.patience;
}

void UdpDevice::take(std::span<const std::byte> datagram, const UdpAddress& from,
                     std::int64_t nanoseconds) noexcept
{
    ++report_.received;
    StatePacket packet;
    if (decode(datagram, packet) != PacketFault::none) {
        ++report_.malformed;
        return;
    }
    switch (order_.judge(packet.session, packet.sequence, from, nanoseconds)) {
    case PacketVerdict::foreign:
        ++report_.foreign;
        return;
    case PacketVerdict::duplicated:
        ++report_.duplicated;
        return;
    case PacketVerdict::reordered:
        ++report_.reordered;
        return;
    case PacketVerdict::leapt:
        ++report_.leapt;
        return;
    case PacketVerdict::well:
        break;
    }
    report_.sessions = order_.sessions();
    const bool leaves = (packet.flags & StatePacket::leaving) != 0;
    if (!is_in_time(packet, nanoseconds)) {
        ++report_.late;
        if (leaves) order_.leave();
        return;
    }
    report_.lost += order_.accept(packet.sequence, nanoseconds);
    ++report_.accepted;
    if (leaves) order_.leave();
    answered_ = packet;
    reading_.state = device_state(packet);
    ++reading_.sample;
    unanswered_ = true;
}

DeviceReading UdpDevice::read() noexcept
{
    // One byte more than a state, so that longer datagrams are recognised.
    std::array<std::byte, state_packet_size + 1> buffer;
    for (int i = 0; i < datagrams_per_tick; ++i) {
        const auto received = socket_.receive(buffer);
        if (!received) break;
        const std::size_t size = std::min(received->size, buffer.size());
        take(std::span(buffer).first(size), received->from, clock_now());
    }
    return reading_;
}

void UdpDevice::write(const DeviceCommand& command) noexcept
{
    if (!unanswered_) return;
    unanswered_ = false;
    ReplyPacket reply;
    reply.session = answered_.session;
    reply.sequence = answered_.sequence;
    reply.nanoseconds = answered_.nanoseconds;
    reply.command = command;
    reply.max_force = options_.limits.max_force;
    reply.hold_seconds = options_.patience;
    reply.fade_seconds = options_.fade_seconds;
    reply.recovery_seconds = options_.recovery_seconds;
    const bool sent = socket_.send(encode(reply), order_.peer());
    report_.replies += sent ? 1U : 0U;
    report_.unsent += sent ? 0U : 1U;
}

UdpDevice::~UdpDevice()
{
    if (report_.accepted == 0) return;
    unanswered_ = true;
    write({.condition = InputCondition::released, .force_scale = 0}); // once more, without a force
}

std::string UdpDevice::trouble() const
{
    if (report_.accepted > 0) return {};
    if (report_.received > 0) {
        return concat("none of ", report_.received, " packets is a state of version ", udp_version,
                      ": see docs/devices.md for the format");
    }
    return concat("no packet arrived at ", to_text(socket_.address()),
                  ": start the program that controls the device and make it send to this address");
}

} // namespace proxima
