#include "haptics/device/udp_packets.h"

#include "haptics/listening_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

namespace proxima::udp_packets_test {
namespace {

using testing::state_packet;

TEST(UdpPackets, AreLaidOutAsDocumented)
{
    StatePacket packet;
    packet.session = 0x0102030405060708;
    packet.sequence = 9;
    packet.nanoseconds = 0x1122334455667788;
    packet.buttons = 3;
    packet.flags = StatePacket::rotates;
    packet.position = {1, 2, 3};
    packet.velocity = {4, 5, 6};
    packet.quaternion = {0.5, -0.5, 0.5, -0.5};
    const auto bytes = encode(packet);
    static_assert(sizeof bytes == 120);
    EXPECT_EQ(std::memcmp(bytes.data(), "PXUP", 4), 0);
    const auto byte = [&](std::size_t i) { return std::to_integer<int>(bytes[i]); };
    EXPECT_EQ(byte(4), 1);
    EXPECT_EQ(byte(5), 0);
    EXPECT_EQ(byte(6), 120);
    EXPECT_EQ(byte(8), 8);
    EXPECT_EQ(byte(15), 1);
    EXPECT_EQ(byte(16), 9);
    EXPECT_EQ(byte(24), 0x88);
    EXPECT_EQ(byte(32), 3);
    EXPECT_EQ(byte(36), 1);
    double y = 0;
    std::memcpy(&y, bytes.data() + 48, sizeof y); // this machine is little-endian, as the packet
    EXPECT_EQ(y, 2);
    std::memcpy(&y, bytes.data() + 112, sizeof y);
    EXPECT_EQ(y, -0.5);
    StatePacket back;
    EXPECT_EQ(decode(bytes, back), PacketFault::none);
    EXPECT_EQ(back, packet);
    EXPECT_NEAR((device_state(back).pose.rotation - Mat3::Identity()).norm(), std::sqrt(6), 1e-12);
}

TEST(UdpPackets, GiveTheStateOfADevice)
{
    StatePacket packet;
    packet.position = {1, 2, 3};
    packet.velocity = {4, 5, 6};
    packet.buttons = 5;
    DeviceState state = device_state(packet);
    EXPECT_EQ(state.pose.translation, Vec3(1, 2, 3));
    EXPECT_EQ(state.velocity, Vec3(4, 5, 6));
    EXPECT_EQ(state.buttons, 5U);
    EXPECT_EQ(state.condition, DeviceState().condition);
    packet.flags = StatePacket::leaving;
    EXPECT_EQ(device_state(packet).condition, InputCondition::released);
    // A quarter turn about z, of almost length 1; without the flag and of other lengths none.
    const double half = std::sqrt(0.5);
    for (const double length : {1.0, 1.0009, 0.9991, 1.0011, 0.9989, 0.0}) {
        packet.flags = StatePacket::rotates;
        packet.quaternion = {half * length, 0, 0, half * length};
        state = device_state(packet);
        Mat3 turned;
        turned << 0, -1, 0, 1, 0, 0, 0, 0, 1;
        const bool accepted = std::abs(length - 1) < 1e-3;
        EXPECT_NEAR((state.pose.rotation - (accepted ? turned : Mat3(Mat3::Identity()))).norm(), 0,
                    1e-12)
            << length;
        packet.flags = 0;
        EXPECT_EQ(device_state(packet).pose.rotation, Mat3(Mat3::Identity()));
    }
}

TEST(UdpPackets, RepliesSurviveEncodingAndDecoding)
{
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> number(-10, 10);
    ReplyPacket packet;
    packet.session = random();
    packet.sequence = random();
    packet.nanoseconds = random();
    DeviceCommand& command = packet.command;
    command.condition = InputCondition::clutched;
    command.plane_count = 3;
    command.force = Vec3{number(random), number(random), number(random)};
    command.anchor = Vec3{number(random), number(random), number(random)};
    for (DevicePlane& plane : command.planes)
        plane = {Vec3{number(random), number(random), number(random)}, number(random)};
    for (double* const x : {&command.force_scale, &command.stiffness, &command.damping,
                            &command.static_friction, &command.dynamic_friction, &packet.max_force,
                            &packet.hold_seconds, &packet.fade_seconds, &packet.recovery_seconds})
        *x = number(random);
    const auto bytes = encode(packet);
    ReplyPacket back;
    ASSERT_EQ(decode(bytes, back), PacketFault::none);
    EXPECT_EQ(encode(back), bytes);
    EXPECT_EQ(back.command.planes[2].offset, command.planes[2].offset);
    EXPECT_EQ(back.recovery_seconds, packet.recovery_seconds);
}

TEST(UdpPackets, RepliesAreLaidOutAsDocumented)
{
    ReplyPacket packet;
    packet.session = 0x0102030405060708;
    packet.sequence = 9;
    packet.nanoseconds = 0x1122334455667788;
    DeviceCommand& command = packet.command;
    command.condition = InputCondition::frozen;
    command.plane_count = 2;
    // Each number is the offset where the documentation has it.
    command.force = {40, 48, 56};
    command.force_scale = 64;
    packet.max_force = 72;
    command.stiffness = 80;
    command.damping = 88;
    command.static_friction = 96;
    command.dynamic_friction = 104;
    command.anchor = {112, 120, 128};
    command.planes = {DevicePlane{Vec3(136, 144, 152), 160}, DevicePlane{Vec3(168, 176, 184), 192},
                      DevicePlane{Vec3(200, 208, 216), 224}};
    packet.hold_seconds = 232;
    packet.fade_seconds = 240;
    packet.recovery_seconds = 248;
    const auto bytes = encode(packet);
    static_assert(sizeof bytes == 256);
    EXPECT_EQ(std::memcmp(bytes.data(), "PXDN\1\0\0\1", 8), 0);
    const auto has = [&](std::size_t at, const auto& wanted) {
        EXPECT_EQ(std::memcmp(bytes.data() + at, &wanted, sizeof wanted), 0) << at;
    };
    has(8, packet.session);
    has(16, packet.sequence);
    has(24, packet.nanoseconds);
    has(32, std::uint32_t{3});
    has(36, std::uint32_t{2});
    for (std::size_t at = 40; at < bytes.size(); at += 8) has(at, static_cast<double>(at));
}

TEST(UdpPackets, NameNoMorePlanesThanThereAre)
{
    ReplyPacket packet;
    constexpr std::size_t condition_at = 32;
    constexpr std::size_t planes_at = 36;
    for (const std::uint32_t count : {0U, 1U, 3U, 4U, 255U, 256U, 0x7fffffffU, 0xffffffffU}) {
        auto bytes = encode(packet);
        std::memcpy(bytes.data() + planes_at, &count, sizeof count);
        ReplyPacket back;
        ASSERT_EQ(decode(bytes, back), PacketFault::none);
        EXPECT_EQ(back.command.plane_count, std::min<std::size_t>(count, 3)) << count;
        bytes = encode(packet);
        std::memcpy(bytes.data() + condition_at, &count, sizeof count);
        ASSERT_EQ(decode(bytes, back), PacketFault::none);
        EXPECT_EQ(back.command.condition, count < input_conditions
                                              ? static_cast<InputCondition>(count)
                                              : InputCondition::unsure)
            << count;
    }
}

TEST(UdpPackets, RefuseOtherSizesMagicsAndVersions)
{
    const auto bytes = encode(state_packet(1));
    StatePacket packet;
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_EQ(decode(std::span(bytes).first(size), packet), PacketFault::wrong_size);
    auto wrong = bytes;
    wrong[0] = std::byte{'Q'};
    EXPECT_EQ(decode(wrong, packet), PacketFault::wrong_magic);
    wrong = bytes;
    wrong[4] = std::byte{2};
    EXPECT_EQ(decode(wrong, packet), PacketFault::wrong_version);
    wrong = bytes;
    wrong[7] = std::byte{1};
    EXPECT_EQ(decode(wrong, packet), PacketFault::wrong_size);
}

} // namespace
} // namespace proxima::udp_packets_test
