// Whole sessions over UDP: a hand in a thread and a loop of its own, in real time.
#include "haptics/device/remote_servo.h"
#include "haptics/device_session.h"
#include "haptics/listening_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>

namespace proxima {
namespace {

using testing::CubeScene;
using testing::listening_device;
using testing::run_session;
using testing::SessionFelt;
using testing::state_packet;

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
    const auto device = listening_device();
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

TEST(UdpSession, AHandFeelsTheSurfaceOverLoopback)
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

TEST(UdpSession, TwoHandsFeelAtOnce)
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

TEST(UdpSession, ABadLineCausesNoForceSpikes)
{
    const LoopbackFelt felt = steady_loopback({.lose = 0.2, .twice = 0.2, .swap = 0.2}, 1200, true);
    EXPECT_GT(felt.report.duplicated, 20U);
    EXPECT_GT(felt.report.reordered, 20U);
    EXPECT_GT(felt.report.lost, 20U);
    expect_rest_at_end(felt.hand);
    EXPECT_LT(felt.hand.largest_step, largest_change());
}

TEST(UdpSession, ACutLineFadesTheForceOnBothSidesAndRecovers)
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

} // namespace
} // namespace proxima
