// What goes over the wire between a device in another program and the renderer: two datagrams of
// fixed size, little-endian, described byte by byte in docs/devices.md.
//
//     state  device ──▶ renderer    pose, velocity, buttons, number and time of the sample
//     reply  renderer ──▶ device    force, and the planes it comes from, for a servo loop there
#pragma once

#include "proxima/device.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

inline constexpr std::uint16_t udp_version = 1;
inline constexpr std::size_t state_packet_size = 120;
inline constexpr std::size_t reply_packet_size = 256;

/// What the device says. Numbers are as they came: any, also none.
struct StatePacket {
    static constexpr std::uint32_t rotates = 1; ///< flag: the quaternion has a meaning
    static constexpr std::uint32_t leaving = 2; ///< flag: the device says goodbye

    std::uint64_t session = 0;     ///< any number that the device chose when it began
    std::uint64_t sequence = 0;    ///< of the sample: each larger than the one before
    std::uint64_t nanoseconds = 0; ///< of the device's clock, from any beginning
    std::uint32_t buttons = 0;
    std::uint32_t flags = 0;
    std::array<double, 3> position{};                ///< m
    std::array<double, 3> velocity{};                ///< m/s
    std::array<double, 4> quaternion = {1, 0, 0, 0}; ///< w, x, y, z

    friend bool operator==(const StatePacket&, const StatePacket&) = default;
};

/// What the device gets.
struct ReplyPacket {
    std::uint64_t session = 0;     ///< of the state it answers
    std::uint64_t sequence = 0;    ///< of that state
    std::uint64_t nanoseconds = 0; ///< of that state: when it comes back, the way there and back
    DeviceCommand command;
    double max_force = 0;        ///< N
    double hold_seconds = 0;     ///< how long a reply is good for, without another one
    double fade_seconds = 0;     ///< in which the force fades after that, and comes back
    double recovery_seconds = 0; ///< in which the force goes over to new planes
};

enum class PacketFault : std::uint8_t { none, wrong_size, wrong_magic, wrong_version };

/// noexcept, without allocation; nothing beyond the span is read, whatever it holds.
[[nodiscard]] PacketFault decode(std::span<const std::byte> datagram, StatePacket& packet) noexcept;
[[nodiscard]] PacketFault decode(std::span<const std::byte> datagram, ReplyPacket& packet) noexcept;

[[nodiscard]] std::array<std::byte, state_packet_size> encode(const StatePacket& packet) noexcept;
[[nodiscard]] std::array<std::byte, reply_packet_size> encode(const ReplyPacket& packet) noexcept;

/// The state as the renderer takes it: a quaternion that is none leaves the rotation away.
[[nodiscard]] DeviceState device_state(const StatePacket& packet) noexcept;

} // namespace proxima
