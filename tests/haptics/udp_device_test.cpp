#include "haptics/device/udp_device.h"

#include "haptics/device/remote_servo.h"
#include "haptics/device_session.h"
#include "proxima/device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>
#include <random>
#include <thread>

namespace proxima {
namespace {

using testing::CubeScene;
using testing::run_session;
using testing::SessionFelt;

constexpr UdpAddress device_side{0x7f000001, 4000};
constexpr UdpAddress somebody{0x7f000001, 4001};
constexpr std::int64_t millisecond = 1'000'000;

std::unique_ptr<UdpDevice> listening()
{
    auto device = UdpDevice::open({});
    EXPECT_TRUE(device) << describe(device.error());
    return std::move(*device);
}

StatePacket state_packet(std::uint64_t sequence)
{
    StatePacket packet;
    packet.session = 77;
    packet.sequence = sequence;
    packet.nanoseconds = sequence * millisecond;
    packet.position = {0.001 * static_cast<double>(sequence), 0, 0};
    return packet;
}

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
    for (double* const x : {&command.trust, &command.stiffness, &command.damping,
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

TEST(UdpDevice, CountsLostDuplicatedAndReorderedPackets)
{
    const auto device = listening();
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
    EXPECT_EQ(device->read().state.condition, InputCondition::gone);
}

TEST(UdpDevice, ANumberTooHighToFollowLocksNobodyOut)
{
    const auto device = listening();
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

TEST(UdpDevice, ForgetsAFirstNumberThatIsTooHighAfterASecond)
{
    const auto device = listening();
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
    const auto device = listening();
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
    const auto device = listening();
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

TEST(UdpDevice, SurvivesAnyBytes)
{
    // What is malformed is refused, what is well formed may hold any numbers: no force spikes.
    const CubeScene scene;
    std::mt19937_64 random(11);
    const auto device = listening();
    std::uint64_t sequence = 0;
    const SessionFelt felt =
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
    EXPECT_GT(felt.input.faulty_ticks, 0U);
}

/// The device's side of a loopback session: a hand in a loop of its own, and a line that loses,
/// doubles and delays.
struct Line {
    double lose = 0;
    double twice = 0;
    double swap = 0;   ///< sent after the next one
    int cut_from = -1; ///< ms: nothing gets through
    int cut_to = -1;
};

/// The hand begins above the cube's upper face and wants to be below it, m.
constexpr double begins_above = 0.01;
constexpr double wants_below = 0.015;

/// Of a hand at rest on the face, N: its spring and the wall's in a row.
double force_at_rest()
{
    const double hand = HandModel{}.hand_stiffness;
    const double wall = ForceOptions{}.stiffness;
    return wants_below * hand * wall / (hand + wall);
}

/// How far the force may be from that after so many ticks of touching, N: by what is left of the
/// hand's motion, which dies away with its damping over twice its mass. A force that is late by
/// some time takes that much of the wall's stiffness off the damping: by 5 ms, as on a busy machine.
double left_of_motion(int ticks)
{
    constexpr double late = 5e-3;
    const HandModel hand;
    const double wall = ForceOptions{}.stiffness;
    const double damping = hand.hand_damping + hand.device_damping - wall * late;
    const double seconds = ticks * hand.tick_seconds;
    return wall * (begins_above + wants_below) * std::exp(-damping / (2 * hand.mass) * seconds);
}

/// How much the force may change in a tick, N: by the hand's motion at its fastest, that of a damped
/// spring let go from rest, and by trust that comes back where the hand is as deep as it wants to be.
double largest_change()
{
    const HandModel hand;
    const ForceOptions wall;
    const double rate = std::sqrt(hand.hand_stiffness / hand.mass);
    const double damping = (hand.hand_damping + hand.device_damping) / (2 * hand.mass * rate);
    const double phase = std::acos(damping);
    const double speed =
        (begins_above + wants_below) * rate * std::exp(-phase / std::tan(phase)); // 0.44 m/s
    const double trust = hand.tick_seconds / wall.loss_seconds;
    return wall.stiffness * (speed * hand.tick_seconds + wants_below * trust); // 0.37 N
}

struct HandOverLine {
    std::vector<double> forces;
    std::vector<int> trusted; ///< at each tick: since when the force is given in full, in ticks
    double largest_step = 0;  ///< of the force, N per tick since the reply before
    std::uint64_t replies = 0;
};

HandOverLine hand_over_line(const UdpAddress& to, const CubeScene& scene, const Line& line, int ms,
                            bool own_servo)
{
    UdpSocket socket = *UdpSocket::listen({});
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> part(0, 1);
    SimulatedHand hand({}, Vec3(0.003, 0.001, scene.half + begins_above));
    const Vec3 target(0.003, 0.001, scene.half - wants_below);
    RemoteServo servo(3.3);
    HandOverLine result;
    result.forces.reserve(static_cast<std::size_t>(ms));
    result.trusted.reserve(static_cast<std::size_t>(ms));
    Vec3 force = Vec3::Zero();
    double trust = 0; // of the last reply
    int heard_at = 0;
    std::optional<std::array<std::byte, state_packet_size>> held_back;
    const auto begin = std::chrono::steady_clock::now();
    for (int tick = 0; tick < ms; ++tick) {
        std::this_thread::sleep_until(begin + std::chrono::milliseconds(tick));
        const DeviceState state = hand.state();
        StatePacket packet = state_packet(static_cast<std::uint64_t>(tick) + 1);
        for (int i = 0; i < 3; ++i) {
            packet.position[static_cast<std::size_t>(i)] = state.pose.translation[i];
            packet.velocity[static_cast<std::size_t>(i)] = state.velocity[i];
        }
        const auto bytes = encode(packet);
        const bool cut = tick >= line.cut_from && tick < line.cut_to;
        if (!cut && part(random) >= line.lose) {
            if (part(random) < line.swap && !held_back) {
                held_back = bytes;
            } else {
                socket.send(bytes, to);
                if (part(random) < line.twice) socket.send(bytes, to);
                if (held_back) socket.send(*held_back, to);
                held_back.reset();
            }
        }
        const double now = 1e-3 * tick;
        const int silence = servo.trust() > 0 ? std::clamp(tick - heard_at, 1, 20) : 1;
        std::array<std::byte, reply_packet_size> buffer{};
        while (const auto received = socket.receive(buffer)) {
            ReplyPacket reply;
            if (cut || decode(std::span(buffer).first(received->size), reply) != PacketFault::none)
                continue;
            ++result.replies;
            servo.take(reply, now);
            trust = reply.command.trust;
            heard_at = tick;
            if (!own_servo) force = reply.command.force;
        }
        const Vec3 before = force;
        const Vec3 mine = servo.force(state.pose.translation, state.velocity, now);
        if (own_servo) force = mine;
        // What changes while no reply comes is felt at once when one does.
        const int ticks = heard_at == tick ? silence : 1;
        result.largest_step = std::max(result.largest_step, (force - before).norm() / ticks);
        result.forces.push_back(force.norm());
        const bool in_full = trust == 1 && servo.trust() == 1;
        result.trusted.push_back(in_full && tick > 0 ? result.trusted.back() + 1 : 0);
        hand.step(force, target);
    }
    return result;
}

struct LoopbackFelt {
    bool began_outside = false; ///< the session heard of the hand before it was in the cube
    HandOverLine hand;
    SessionFelt session;
    UdpReport report;
};

LoopbackFelt loopback(const Line& line, int ms, bool own_servo)
{
    const CubeScene scene;
    const auto device = listening();
    LoopbackFelt felt;
    std::thread hand(
        [&] { felt.hand = hand_over_line(device->address(), scene, line, ms, own_servo); });
    felt.session =
        run_session(scene, *device, static_cast<std::uint64_t>(ms), {}, {}, Pace::best_effort);
    hand.join();
    for (const RecordedTick& tick : felt.session.recording.ticks) {
        if (!std::isfinite(tick.position[2])) continue;
        felt.began_outside = tick.position[2] > scene.half;
        break;
    }
    felt.report = device->report();
    return felt;
}

/// Expects the force of a hand at rest.
void expect_rest(const HandOverLine& hand, std::size_t tick)
{
    EXPECT_NEAR(hand.forces[tick], force_at_rest(), left_of_motion(hand.trusted[tick])) << tick;
}
void expect_rest_at_end(const HandOverLine& hand)
{
    expect_rest(hand, hand.forces.size() - 1);
}

/// Whether the hand came from outside, the force was given in full for so long that little is left
/// of the hand's motion, at the end and before the line is cut, and nothing interrupted its return.
bool is_steady(const LoopbackFelt& felt, const Line& line)
{
    constexpr int at_end = 300;     // 0.14 N are left
    constexpr int before_cut = 200; // 0.6 N
    const std::vector<int>& trusted = felt.hand.trusted;
    if (line.cut_from > 0 && trusted[static_cast<std::size_t>(line.cut_from) - 1] < before_cut)
        return false;
    return felt.began_outside && trusted.back() >= at_end &&
           felt.session.input.longest_recovery < 2 * ForceOptions{}.loss_seconds;
}

/// Tries again where a busy machine has begun late, or kept the line silent for longer than its
/// patience.
LoopbackFelt steady_loopback(const Line& line, int ms, bool own_servo)
{
    LoopbackFelt felt;
    for (int attempt = 0; attempt < 5; ++attempt) {
        felt = loopback(line, ms, own_servo);
        if (is_steady(felt, line)) break;
    }
    EXPECT_TRUE(is_steady(felt, line));
    return felt;
}

TEST(UdpDevice, AHandFeelsTheSurfaceOverLoopback)
{
    for (const bool own_servo : {false, true}) {
        const LoopbackFelt felt = steady_loopback({}, 800, own_servo);
        EXPECT_GT(felt.report.accepted, 100U); // of 800, on a machine that does other things
        EXPECT_GT(felt.hand.replies, 100U);
        EXPECT_EQ(felt.report.malformed + felt.report.foreign + felt.report.unsent, 0U);
        SCOPED_TRACE(own_servo ? "a servo of its own" : "the forces of the replies");
        expect_rest_at_end(felt.hand);
        EXPECT_EQ(felt.session.quality.passes, 0U);
    }
}

TEST(UdpDevice, TwoHandsFeelAtOnce)
{
    LoopbackFelt left;
    LoopbackFelt right;
    std::thread other([&] { left = steady_loopback({}, 800, true); });
    right = steady_loopback({}, 800, false);
    other.join();
    for (const LoopbackFelt* const felt : {&left, &right}) {
        EXPECT_EQ(felt->report.foreign, 0U);
        expect_rest_at_end(felt->hand);
    }
}

TEST(UdpDevice, ABadLineCausesNoForceSpikes)
{
    const LoopbackFelt felt = steady_loopback({.lose = 0.2, .twice = 0.2, .swap = 0.2}, 1200, true);
    EXPECT_GT(felt.report.duplicated, 20U);
    EXPECT_GT(felt.report.reordered, 20U);
    EXPECT_GT(felt.report.lost, 20U);
    expect_rest_at_end(felt.hand);
    EXPECT_LT(felt.hand.largest_step, largest_change());
}

TEST(UdpDevice, ACutLineFadesTheForceOnBothSidesAndRecovers)
{
    const LoopbackFelt felt = steady_loopback({.cut_from = 700, .cut_to = 1000}, 1600, true);
    expect_rest(felt.hand, 699);
    // The device's side: 20 ms of holding and 50 of fading, by its own clock.
    for (std::size_t tick = 780; tick < 1000; ++tick) EXPECT_EQ(felt.hand.forces[tick], 0) << tick;
    expect_rest_at_end(felt.hand);
    EXPECT_LT(felt.hand.largest_step, largest_change());
    EXPECT_GE(felt.session.input.silences, 1U);
    EXPECT_GE(felt.session.input.recoveries, 1U);
    // 300 ms less the patience, and less what a busy machine leaves out.
    EXPECT_GE(felt.session.input.longest_fault, 0.2);
    EXPECT_LT(felt.session.input.longest_recovery, 2 * ForceOptions{}.loss_seconds);
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
} // namespace proxima
