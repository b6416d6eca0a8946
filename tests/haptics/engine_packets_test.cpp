#include "haptics/channel/engine_packets.h"

#include "exact_copy.h"
#include "haptics/engine_side.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace proxima::engine_packets_test {
namespace {

using namespace testing;

constexpr std::uint64_t seed = 20;

Vec3 any_vector(std::mt19937_64& random)
{
    std::uniform_real_distribution<double> number(-10, 10);
    return {number(random), number(random), number(random)};
}

ScenePacket any_scene(std::mt19937_64& random, std::size_t count)
{
    ScenePacket packet;
    packet.session = random();
    packet.sequence = random();
    packet.nanoseconds = random();
    packet.flags = 1;
    packet.reply_every = 7;
    packet.period = 0.01;
    packet.material_seconds = 0.05;
    packet.count = count;
    for (PacketObject& object : std::span(packet.objects).first(count)) {
        object.object = static_cast<std::uint32_t>(random() % max_scene_objects);
        object.flags = static_cast<std::uint32_t>(random() % 8);
        object.position = any_vector(random);
        object.quaternion = {0.5, -0.5, 0.5, -0.5};
        object.velocity = any_vector(random);
        object.spin = any_vector(random);
        object.material = {500, 2, 0.5, 0.25};
    }
    return packet;
}

double number_at(std::span<const std::byte> bytes, std::size_t offset)
{
    double number = 0;
    std::memcpy(&number, bytes.data() + offset, sizeof number);
    return number;
}

std::uint32_t whole_at(std::span<const std::byte> bytes, std::size_t offset)
{
    std::uint32_t number = 0;
    std::memcpy(&number, bytes.data() + offset, sizeof number);
    return number;
}

// The offsets of docs/engine_channel.md, by hand.
TEST(EnginePackets, ScenesAreLaidOutAsDocumented)
{
    ScenePacket packet;
    packet.session = 0x0102030405060708;
    packet.flags = 1;
    packet.reply_every = 9;
    packet.period = 0.25;
    packet.material_seconds = 0.5;
    packet.count = 2;
    PacketObject& object = packet.objects[1];
    object.object = 3;
    object.flags = 5;
    object.position = {1, 2, 3};
    object.quaternion = {4, 5, 6, 7};
    object.velocity = {8, 9, 10};
    object.spin = {11, 12, 13};
    object.material = {14, 15, 17, 16};
    const auto bytes = bytes_of(packet);
    ASSERT_EQ(bytes.size(), 64U + 2 * 144U);
    EXPECT_EQ(std::memcmp(bytes.data(), "PXSC\x02\0\x60\x01\x08\x07", 10), 0);
    EXPECT_EQ(whole_at(bytes, 32), 2U);
    EXPECT_EQ(whole_at(bytes, 36), 1U);
    EXPECT_EQ(number_at(bytes, 40), 0.25);
    EXPECT_EQ(number_at(bytes, 48), 0.5);
    EXPECT_EQ(whole_at(bytes, 56), 9U);
    const auto second = std::span(bytes).subspan(64 + 144);
    EXPECT_EQ(whole_at(second, 0), 3U);
    EXPECT_EQ(whole_at(second, 4), 5U);
    constexpr std::array<double, 17> numbers = {1,  2,  3,  4,  5,  6,  7,  8, 9,
                                                10, 11, 12, 13, 14, 15, 17, 16};
    for (std::size_t i = 0; i < numbers.size(); ++i)
        EXPECT_EQ(number_at(second, 8 + 8 * i), numbers[i]) << i;
}

TEST(EnginePackets, TouchIsLaidOutAsDocumented)
{
    TouchPacket packet;
    // Each number is the offset where the documentation has it, but for the number of contacts.
    packet.session = 8;
    packet.sequence = 16;
    packet.nanoseconds = 24;
    packet.engine_session = 32;
    packet.engine_sequence = 40;
    packet.engine_nanoseconds = 48;
    packet.accepted = 56;
    packet.lost = 64;
    packet.refused = 72;
    packet.refused_objects = 80;
    packet.unsent = 88;
    packet.condition = 96;
    packet.flags = 100;
    packet.hold = 104;
    packet.contact_count = 2;
    packet.buttons = 112;
    packet.units_per_metre = 120;
    packet.center = {128, 136, 144};
    packet.device = {152, 160, 168};
    packet.rotation = {176, 184, 192, 200};
    packet.proxy = {208, 216, 224};
    packet.anchor = {232, 240, 248};
    packet.force = {256, 264, 272};
    packet.torque = {280, 288, 296};
    packet.normal = {304, 312, 320};
    packet.depth = 328;
    packet.surface_velocity = {336, 344, 352};
    packet.force_scale = 360;
    packet.softness = 368;
    packet.added_damping = 376;
    packet.contacts = {PacketContact{384, 388, {392, 400, 408}, {416, 424, 432}, 440},
                       PacketContact{448, 452, {456, 464, 472}, {480, 488, 496}, 504},
                       PacketContact{512, 516, {520, 528, 536}, {544, 552, 560}, 568}};
    std::array<std::byte, touch_packet_size> bytes;
    encode(packet, bytes);
    static_assert(sizeof bytes == 576);
    EXPECT_EQ(std::memcmp(bytes.data(), "PXTO\x02\0\x40\x02", 8), 0);
    for (std::uint64_t at = 8; at < 96; at += 8)
        EXPECT_EQ(std::memcmp(bytes.data() + at, &at, sizeof at), 0) << at;
    for (const std::uint32_t at : {96U, 100U, 104U, 112U}) EXPECT_EQ(whole_at(bytes, at), at);
    EXPECT_EQ(whole_at(bytes, 108), 2U);
    EXPECT_EQ(whole_at(bytes, 116), 0U);
    for (std::size_t at = 120; at < 384; at += 8)
        EXPECT_EQ(number_at(bytes, at), static_cast<double>(at));
    for (const std::uint32_t contact : {384U, 448U, 512U}) {
        EXPECT_EQ(whole_at(bytes, contact), contact);
        EXPECT_EQ(whole_at(bytes, contact + 4), contact + 4);
        for (std::size_t at = contact + 8; at < contact + 64; at += 8)
            EXPECT_EQ(number_at(bytes, at), static_cast<double>(at));
    }
}

TEST(EnginePackets, SurviveEncodingAndDecoding)
{
    std::mt19937_64 random(seed);
    for (std::size_t count = 0; count <= max_scene_objects; ++count) {
        const auto bytes = bytes_of(any_scene(random, count));
        ScenePacket back;
        ASSERT_EQ(decode(bytes, back), PacketFault::none);
        EXPECT_EQ(back.count, count);
        EXPECT_EQ(bytes_of(back), bytes);
    }
    // Any bits of a touch packet, NaN among them, come back; a count of contacts is cut to 3.
    std::array<std::byte, touch_packet_size> bytes;
    TouchPacket packet;
    encode(packet, bytes);
    for (std::size_t i = packet_header_size; i < bytes.size(); ++i)
        bytes[i] = static_cast<std::byte>(random());
    std::memset(bytes.data() + 116, 0, 4); // reserved
    ASSERT_EQ(decode(bytes, packet), PacketFault::none);
    EXPECT_EQ(packet.contact_count, 3U);
    bytes[108] = std::byte{3};
    bytes[109] = bytes[110] = bytes[111] = std::byte{0};
    std::array<std::byte, touch_packet_size> again;
    encode(packet, again);
    EXPECT_EQ(again, bytes);
}

TEST(EnginePackets, RefuseEveryOtherLengthMagicAndVersion)
{
    std::mt19937_64 random(seed);
    const auto bytes = bytes_of(any_scene(random, 3));
    ScenePacket packet;
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        const auto copy = exact_copy(reinterpret_cast<const std::uint8_t*>(bytes.data()), size);
        EXPECT_EQ(decode(std::span(copy.get(), size), packet), PacketFault::wrong_size);
    }
    // A header that fits the length, and a count that does not.
    for (const std::uint32_t count : {0U, 2U, 4U, 64U, 65U, 0x1c71c73U, ~0U}) {
        auto wrong = bytes;
        std::memcpy(wrong.data() + 32, &count, sizeof count);
        EXPECT_EQ(decode(wrong, packet), PacketFault::wrong_size) << count;
        EXPECT_EQ(packet.count, 0U);
    }
    auto wrong = bytes;
    wrong[0] = std::byte{'Q'};
    EXPECT_EQ(decode(wrong, packet), PacketFault::wrong_magic);
    wrong = bytes;
    wrong[4] = std::byte{3};
    EXPECT_EQ(decode(wrong, packet), PacketFault::wrong_version);
    EXPECT_EQ(decode(std::span(wrong).first(8), packet), PacketFault::wrong_version);
    TouchPacket touch;
    std::array<std::byte, touch_packet_size> heard;
    encode(touch, heard);
    for (std::size_t size = 0; size < heard.size(); ++size)
        EXPECT_EQ(decode(std::span(heard).first(size), touch), PacketFault::wrong_size);
}

} // namespace
} // namespace proxima::engine_packets_test
