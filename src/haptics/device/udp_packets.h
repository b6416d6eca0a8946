// The datagrams between a device in another program and the renderer: two of fixed size,
// little-endian, described byte by byte in docs/devices.md.
//
//     state  device ──▶ renderer    pose, velocity, buttons, number and time of the sample
//     reply  renderer ──▶ device    force, and its planes, for a servo loop of the device
#pragma once

#include "haptics/device/packet_bytes.h"
#include "proxima/device.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

inline constexpr std::uint16_t udp_version = 1;
inline constexpr std::size_t state_packet_size = 120;
inline constexpr std::size_t reply_packet_size = 256;

/// The state of a device. Numbers are as they came, perhaps NaN or infinite.
struct StatePacket {
    static constexpr std::uint32_t rotates = 1; ///< flag: the quaternion has a meaning
    static constexpr std::uint32_t leaving = 2; ///< flag: the device ends the session

    std::uint64_t session = 0;     ///< any number, chosen by the device when it starts
    std::uint64_t sequence = 0;    ///< of the sample: each larger than the one before
    std::uint64_t nanoseconds = 0; ///< of the device's clock, from any origin
    std::uint32_t buttons = 0;
    std::uint32_t flags = 0;
    std::array<double, 3> position{};                ///< m
    std::array<double, 3> velocity{};                ///< m/s
    std::array<double, 4> quaternion = {1, 0, 0, 0}; ///< w, x, y, z

    friend bool operator==(const StatePacket&, const StatePacket&) = default;
};

/// The answer to a device.
struct ReplyPacket {
    std::uint64_t session = 0;     ///< of the state that it answers
    std::uint64_t sequence = 0;    ///< of that state
    std::uint64_t nanoseconds = 0; ///< of that state, to measure the round trip
    DeviceCommand command;
    double max_force = 0;        ///< N
    double hold_seconds = 0;     ///< for which a reply lasts without another one
    double fade_seconds = 0;     ///< in which the force fades after that, and comes back
    double recovery_seconds = 0; ///< in which the force crosses over to new planes
};

/// noexcept, without allocation; nothing beyond the span is read, whatever it holds.
[[nodiscard]] PacketFault decode(std::span<const std::byte> datagram, StatePacket& packet) noexcept;
[[nodiscard]] PacketFault decode(std::span<const std::byte> datagram, ReplyPacket& packet) noexcept;

[[nodiscard]] std::array<std::byte, state_packet_size> encode(const StatePacket& packet) noexcept;
[[nodiscard]] std::array<std::byte, reply_packet_size> encode(const ReplyPacket& packet) noexcept;

/// The state for a renderer. An invalid quaternion leaves the rotation out.
[[nodiscard]] DeviceState device_state(const StatePacket& packet) noexcept;

} // namespace proxima
