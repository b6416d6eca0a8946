// A device that hears packets over UDP, and the packets that tests send it.
#pragma once

#include "haptics/device/udp_device.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>

namespace proxima::testing {

/// Where the packets come from.
inline constexpr UdpAddress device_side{0x7f000001, 4000};
inline constexpr std::int64_t millisecond = 1'000'000;

[[nodiscard]] inline std::unique_ptr<UdpDevice> listening_device()
{
    auto device = UdpDevice::open({});
    EXPECT_TRUE(device) << describe(device.error());
    return std::move(*device);
}

/// The packet of that number of a device that reports every millisecond.
[[nodiscard]] inline StatePacket state_packet(std::uint64_t sequence)
{
    StatePacket packet;
    packet.session = 77;
    packet.sequence = sequence;
    packet.nanoseconds = sequence * millisecond;
    packet.position = {0.001 * static_cast<double>(sequence), 0, 0};
    return packet;
}

} // namespace proxima::testing
