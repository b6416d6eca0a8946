#include "haptics/device/udp_device.h"

#include "haptics/device/remote_servo.h"
#include "haptics/device_session.h"
#include "haptics/listening_device.h"

#include <gtest/gtest.h>

#include <random>

namespace proxima::udp_device_test {
namespace {

using testing::CubeScene;
using testing::device_side;
using testing::listening_device;
using testing::millisecond;
using testing::run_session;
using testing::SessionResult;
using testing::state_packet;

constexpr UdpAddress somebody{0x7f000001, 4001};

TEST(UdpDevice, CountsLostDuplicatedAndReorderedPackets)
{
    const auto device = listening_device();
    const auto take = [&](const StatePacket& packet, std::int64_t ms,
                          const UdpAddress& from = device_side) {
        device->take(encode(packet), from, ms * millisecond);
    };
    take(state_packet(1), 1001);
    take(state_packet(2), 1002);
    take(state_packet(2), 1002);           // duplicated
    take(state_packet(6), 1006);           // three lost
    take(state_packet(5), 1006);           // reordered
    take(state_packet(7), 1007, somebody); // foreign
    StatePacket late = state_packet(8);
    take(late, 1008 + 21); // 21 ms longer on the way than the others
    late = state_packet(30);
    take(late, 1030 + 19); // within the patience
    EXPECT_EQ(device->read().sample, 4U);
    EXPECT_EQ(device->read().state.pose.translation.x(), 0.03);
    const UdpReport& report = device->report();
    EXPECT_EQ(report.received, 8U);
    EXPECT_EQ(report.accepted, 4U);
    EXPECT_EQ(report.duplicated, 1U);
    EXPECT_EQ(report.reordered, 1U);
    EXPECT_EQ(report.foreign, 1U);
    EXPECT_EQ(report.late, 1U);
    EXPECT_EQ(report.lost, 3U + 23U);
    EXPECT_EQ(report.sessions, 1U);
    // Another device comes once this one was silent for a second; the same one, begun anew, sooner.
    take(state_packet(31), 1049 + 999, somebody);
    EXPECT_EQ(report.foreign, 2U);
    StatePacket anew = state_packet(1);
    anew.session = 78;
    take(anew, 1049 + 1000);
    EXPECT_EQ(report.sessions, 2U);
    EXPECT_EQ(device->read().sample, 5U);
    take(state_packet(1), 1049 + 2100, somebody);
    EXPECT_EQ(report.sessions, 3U);
    // It says goodbye.
    StatePacket leaving = state_packet(2);
    leaving.flags = StatePacket::leaving;
    take(leaving, 1049 + 2101, somebody);
    EXPECT_EQ(device->read().state.condition, InputCondition::released);
}

TEST(UdpDevice, AnotherDeviceComesAtOnceWhenTheFirstLeaves)
{
    const auto device = listening_device();
    const auto take = [&](const StatePacket& packet, const UdpAddress& from, std::int64_t ms) {
        device->take(encode(packet), from, ms * millisecond);
    };
    const UdpReport& report = device->report();
    take(state_packet(1), device_side, 1001);
    StatePacket other = state_packet(1);
    other.session = 78;
    take(other, somebody, 1002);
    EXPECT_EQ(report.foreign, 1U);
    StatePacket leaving = state_packet(2);
    leaving.flags = StatePacket::leaving;
    take(leaving, device_side, 1002);
    EXPECT_EQ(device->read().state.condition, InputCondition::released);
    other.sequence = 2;
    take(other, somebody, 1003);
    EXPECT_EQ(report.sessions, 2U);
    EXPECT_EQ(report.accepted, 3U);
    EXPECT_EQ(device->read().state.condition, InputCondition::well);
    // The first one has no way back while this one is there.
    take(state_packet(3), device_side, 1004);
    EXPECT_EQ(report.foreign, 2U);
    // A leave that was long on the way counts, too.
    other.sequence = 3;
    other.flags = StatePacket::leaving;
    take(other, somebody, 1003 + 200);
    EXPECT_EQ(report.late, 1U);
    take(state_packet(204), device_side, 1204);
    EXPECT_EQ(report.sessions, 3U);
    EXPECT_EQ(report.accepted, 4U);
}

TEST(UdpDevice, ANumberTooHighToFollowLocksNobodyOut)
{
    const auto device = listening_device();
    const auto take = [&](std::uint64_t sequence, std::int64_t ms) {
        StatePacket packet = state_packet(sequence);
        packet.nanoseconds = static_cast<std::uint64_t>(ms * millisecond);
        device->take(encode(packet), device_side, ms * millisecond);
    };
    const UdpReport& report = device->report();
    take(1, 1001);
    take(~std::uint64_t{0}, 1002); // refused
    take(1 + 65537, 1002);         // and this
    for (std::uint64_t i = 2; i < 100; ++i) take(i, 1001 + static_cast<std::int64_t>(i));
    EXPECT_EQ(report.leapt, 2U);
    EXPECT_EQ(report.accepted, 99U);
    EXPECT_EQ(report.reordered + report.lost, 0U);
    EXPECT_EQ(report.sessions, 1U);
}

TEST(UdpDevice, FollowsALeapOf65536Numbers)
{
    const auto device = listening_device();
    const auto take = [&](std::uint64_t sequence, std::int64_t ms) {
        StatePacket packet = state_packet(sequence);
        packet.nanoseconds = static_cast<std::uint64_t>(ms * millisecond);
        device->take(encode(packet), device_side, ms * millisecond);
    };
    take(1, 1001);
    take(1 + 65536, 1002);
    EXPECT_EQ(device->report().accepted, 2U);
    EXPECT_EQ(device->report().lost, 65535U);
    take(1 + 2 * 65536 + 1, 1003);
    EXPECT_EQ(device->report().leapt, 1U);
}

TEST(UdpDevice, ForgetsAFirstNumberThatIsTooHighAfterASecond)
{
    const auto device = listening_device();
    const auto take = [&](std::uint64_t sequence, std::int64_t ms) {
        StatePacket packet = state_packet(sequence);
        packet.nanoseconds = static_cast<std::uint64_t>(ms * millisecond);
        device->take(encode(packet), device_side, ms * millisecond);
    };
    const UdpReport& report = device->report();
    take(~std::uint64_t{0}, 1000);
    for (std::uint64_t i = 1; i <= 2000; ++i) take(i, 1000 + static_cast<std::int64_t>(i));
    EXPECT_EQ(report.reordered, 999U);
    EXPECT_EQ(report.accepted, 1U + 1001U);
    EXPECT_EQ(report.sessions, 2U);
    EXPECT_EQ(report.lost, 0U);
}

TEST(UdpDevice, AcceptsARestartedDeviceAfterASecondOfSilence)
{
    // Its program is started again, with the same port, session and numbers, and another clock.
    const auto device = listening_device();
    const auto take = [&](std::uint64_t sequence, std::int64_t ms) {
        device->take(encode(state_packet(sequence)), device_side, ms * millisecond);
    };
    const UdpReport& report = device->report();
    for (int i = 1; i <= 500; ++i) take(static_cast<std::uint64_t>(i), 1000 + i);
    for (int i = 1; i <= 100; ++i) take(static_cast<std::uint64_t>(i), 2499 + i);
    EXPECT_EQ(report.accepted, 600U);
    EXPECT_EQ(report.reordered + report.late, 0U);
    EXPECT_EQ(report.sessions, 2U);
    EXPECT_EQ(report.lost, 0U);
    EXPECT_EQ(device->read().sample, 600U);
}

TEST(UdpDevice, AcceptsAClockSetBackAfterASecond)
{
    const auto device = listening_device();
    StatePacket packet = state_packet(1);
    packet.nanoseconds = 1'000'000'000'000;
    device->take(encode(packet), device_side, 5000 * millisecond);
    for (std::uint64_t i = 2; i < 1200; ++i) {
        packet.sequence = i;
        packet.nanoseconds = i * millisecond;
        device->take(encode(packet), device_side,
                     (5000 + static_cast<std::int64_t>(i)) * millisecond);
    }
    // Those of the second after the first packet are late: numbers 2 to 1000.
    EXPECT_EQ(device->report().late, 999U);
    EXPECT_EQ(device->report().accepted, 1U + 199U);
}

/// Ten packets a second for ten minutes from a sender whose seconds take `pace` of ours. All but the
/// first packet are `delay_ms` longer on the way than it.
const UdpReport& ten_minutes(UdpDevice& device, double pace, std::int64_t delay_ms = 0)
{
    for (std::uint64_t i = 0; i < 6000; ++i) {
        const double sent = 1e8 * static_cast<double>(i);
        StatePacket packet = state_packet(i + 1);
        packet.nanoseconds = static_cast<std::uint64_t>(sent);
        device.take(encode(packet), device_side,
                    5000 * millisecond + static_cast<std::int64_t>(pace * sent) +
                        (i > 0 ? delay_ms : 0) * millisecond);
    }
    return device.report();
}

TEST(UdpDevice, AcceptsClocksThatDriftByATenthOfAPerMille)
{
    for (const double drift : {-0.9e-4, 0.9e-4}) {
        SCOPED_TRACE(drift);
        const auto device = listening_device();
        // 54 ms apart in the end, where 20 ms are the patience.
        EXPECT_EQ(ten_minutes(*device, 1 + drift).accepted, 6000U);
        // Packets that are late for another reason do not add to it.
        const auto slow_way = listening_device();
        EXPECT_EQ(ten_minutes(*slow_way, 1 + drift, 19).accepted, 6000U);
    }
    const auto too_slow_way = listening_device();
    EXPECT_EQ(ten_minutes(*too_slow_way, 1, 21).late, 9U); // then it begins anew
}

TEST(UdpDevice, BeginsAnewWhenAClockIsSlowByAPerCent)
{
    // Each packet is 1 ms longer on the way than the one before: after 20 of them 9 are late, and
    // after a second without a good one all begins anew.
    const auto slow = listening_device();
    const UdpReport& report = ten_minutes(*slow, 1.01);
    EXPECT_EQ(report.accepted, 6000U / 30 * 21);
    EXPECT_EQ(report.late, 6000U / 30 * 9);
    EXPECT_EQ(report.sessions, 1U);
    // A fast one seems ever quicker on the way, so nothing of it is late.
    const auto fast = listening_device();
    EXPECT_EQ(ten_minutes(*fast, 0.99).accepted, 6000U);
}

TEST(UdpDevice, JudgesLatenessByTheQuickestPacketOfClocksThatDrift)
{
    // Fast by a per cent, and slow by half of what is allowed for: 30 ms in ten minutes.
    for (const double pace : {0.99, 1 + 0.5e-4}) {
        SCOPED_TRACE(pace);
        const auto device = listening_device();
        EXPECT_EQ(ten_minutes(*device, pace).late, 0U);
        // More packets, `way_ms` longer on the way than the last.
        const auto next = [&](std::uint64_t more, std::int64_t way_ms) {
            StatePacket packet = state_packet(6000 + more);
            packet.nanoseconds = (5999 + more) * 100 * millisecond;
            device->take(encode(packet), device_side,
                         static_cast<std::int64_t>(pace * 1e8 * 5999) +
                             (5000 + 100 * static_cast<std::int64_t>(more) + way_ms) * millisecond);
        };
        next(1, 21);
        EXPECT_EQ(device->report().late, 1U);
        next(2, 19);
        EXPECT_EQ(device->report().late, 1U);
    }
}

TEST(UdpDevice, ReadsAtMost64DatagramsATick)
{
    const auto device = listening_device();
    UdpSocket sender = *UdpSocket::listen({});
    const auto address = parse_udp_address(device->info().name.substr(4));
    ASSERT_TRUE(address);
    for (std::uint64_t i = 1; i <= 100; ++i)
        ASSERT_TRUE(sender.send(encode(state_packet(i)), *address)) << i;
    EXPECT_EQ(device->read().sample, 64U);
    EXPECT_EQ(device->report().received, 64U);
    EXPECT_EQ(device->read().sample, 100U);
    EXPECT_EQ(device->report().lost, 0U);
}

TEST(UdpDevice, ItsEndTakesTheForceAway)
{
    auto device = listening_device();
    UdpSocket hand = *UdpSocket::listen({});
    auto address = parse_udp_address(device->info().name.substr(4));
    // A tip is 1 mm below a floor. Its device ends while the force pushes it, then after it has faded.
    DeviceCommand pressed = {.force = {0, 0, 0.5}, .stiffness = 500};
    pressed.planes[0].normal = Vec3::UnitZ();
    pressed.plane_count = 1;
    for (const double scale : {1.0, 0.0}) {
        RemoteServo servo(3.3);
        std::array<std::byte, reply_packet_size> bytes{};
        double now = 0;
        const auto feel = [&] {
            EXPECT_TRUE(hand.receive(bytes));
            ReplyPacket reply;
            EXPECT_EQ(decode(bytes, reply), PacketFault::none);
            servo.take(reply, now);
            return reply;
        };
        const auto force = [&] {
            now += 1e-3;
            return servo.force({0, 0, -1e-3}, Vec3::Zero(), now).norm();
        };
        ASSERT_TRUE(hand.send(encode(state_packet(7)), *address));
        EXPECT_EQ(device->read().sample, 1U);
        pressed.force_scale = scale;
        device->write(pressed);
        EXPECT_EQ(feel().command.force, pressed.force);
        double last = 0;
        for (int tick = 0; tick < 15; ++tick) last = force();
        EXPECT_GE(last, 0.1 * scale);
        device.reset();
        const ReplyPacket end = feel();
        EXPECT_EQ(end.sequence, 7U);
        EXPECT_EQ(end.command.condition, InputCondition::released);
        for (int tick = 0; tick < 50; ++tick) EXPECT_EQ(force(), 0) << scale;
        EXPECT_FALSE(hand.receive(bytes));
        device = listening_device();
        address = parse_udp_address(device->info().name.substr(4));
    }
    // One that nobody has sent to has nobody to tell.
    std::array<std::byte, reply_packet_size> bytes{};
    device.reset();
    EXPECT_FALSE(hand.receive(bytes));
}

TEST(UdpDevice, HasAsManyButtonsAsAStateHasBits)
{
    const auto device = listening_device();
    EXPECT_EQ(device->info().buttons, 8 * static_cast<int>(sizeof(StatePacket::buttons)));
    StatePacket packet = state_packet(1);
    packet.buttons = 0x80000001U;
    device->take(encode(packet), device_side, millisecond);
    EXPECT_EQ(device->read().state.buttons, 0x80000001U);
}

TEST(UdpDevice, SurvivesAnyBytes)
{
    // What is malformed is refused, what is well formed may hold any numbers: no force spikes.
    const CubeScene scene;
    std::mt19937_64 random(11);
    const auto device = listening_device();
    std::uint64_t sequence = 0;
    const SessionResult session =
        run_session(scene, *device, 20000, {}, [&](std::uint64_t tick, DeviceInput&) {
            const auto now = static_cast<std::int64_t>((tick + 5000) * millisecond);
            std::array<std::byte, state_packet_size + 8> junk{};
            for (std::byte& byte : junk) byte = static_cast<std::byte>(random() & 255U);
            const std::size_t size = random() % (junk.size() + 1);
            device->take(std::span(junk).first(size), device_side, now);
            auto bytes = encode(state_packet(sequence += random() % 3));
            StatePacket packet = state_packet(sequence);
            packet.position = {0, 0, scene.half - 0.003};
            bytes = encode(packet);
            for (std::uint64_t flips = random() % 4; flips > 0; --flips)
                bytes[random() % bytes.size()] ^= static_cast<std::byte>(1U << random() % 8);
            device->take(bytes, device_side, now);
        });
    EXPECT_GT(device->report().malformed, 10000U);
    EXPECT_GT(device->report().accepted, 1000U);
    EXPECT_GT(session.input.faulty_ticks, 0U);
}

TEST(UdpSocket, ParsesAddressesAndReportsPortsInUse)
{
    EXPECT_EQ(*parse_udp_address("4711"), (UdpAddress{0x7f000001, 4711}));
    EXPECT_EQ(*parse_udp_address("192.168.0.7:65535"), (UdpAddress{0xc0a80007, 65535}));
    EXPECT_EQ(to_text(UdpAddress{0xc0a80007, 65535}), "192.168.0.7:65535");
    for (const char* const text : {"", "x", "65536", "-1", "1.2.3:4", "1.2.3.4:", "1.2.3.4.5:6",
                                   "256.0.0.1:5", "localhost:5", "5 ", "1.2.3.4", ":5"})
        EXPECT_FALSE(parse_udp_address(text)) << text;
    const UdpSocket taken = *UdpSocket::listen({});
    EXPECT_NE(taken.address().port, 0);
    const auto again = UdpSocket::listen(taken.address());
    ASSERT_FALSE(again);
    EXPECT_NE(describe(again.error()).find("127.0.0.1:"), std::string::npos);
}

} // namespace
} // namespace proxima::udp_device_test
