// Whole sessions over UDP: a hand in a thread and a loop of its own, in real time.
#include "haptics/device/remote_servo.h"
#include "haptics/device_session.h"
#include "haptics/listening_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>

namespace proxima::udp_session_test {
namespace {

using testing::CubeScene;
using testing::listening_device;
using testing::run_session;
using testing::SessionResult;
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

/// The force on a hand that rests on the face, in N. The hand's spring and the wall's act in series.
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
/// spring let go from rest, and by a force scale that rises where the hand is deepest.
double largest_change()
{
    const HandModel hand;
    const ForceOptions wall;
    const double rate = std::sqrt(hand.hand_stiffness / hand.mass);
    const double damping = (hand.hand_damping + hand.device_damping) / (2 * hand.mass * rate);
    const double phase = std::acos(damping);
    const double speed =
        (begins_above + wants_below) * rate * std::exp(-phase / std::tan(phase)); // 0.44 m/s
    const double rise = hand.tick_seconds / wall.loss_seconds;
    return wall.stiffness * (speed * hand.tick_seconds + wants_below * rise); // 0.37 N
}

struct HandOverLine {
    std::vector<double> forces;
    std::vector<int> in_full; ///< by tick: for how many ticks the force has been given in full
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
    result.in_full.reserve(static_cast<std::size_t>(ms));
    Vec3 force = Vec3::Zero();
    double force_scale = 0; // of the last reply
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
        const int silence = servo.fade_factor() > 0 ? std::clamp(tick - heard_at, 1, 20) : 1;
        std::array<std::byte, reply_packet_size> buffer{};
        while (const auto received = socket.receive(buffer)) {
            ReplyPacket reply;
            if (cut || decode(std::span(buffer).first(received->size), reply) != PacketFault::none)
                continue;
            ++result.replies;
            servo.take(reply, now);
            force_scale = reply.command.force_scale;
            heard_at = tick;
            if (!own_servo) force = reply.command.force;
        }
        const Vec3 before = force;
        const Vec3 mine = servo.force(state.pose.translation, state.velocity, now);
        if (own_servo) force = mine;
        // What changes while no reply comes changes the force at once when one does.
        const int ticks = heard_at == tick ? silence : 1;
        result.largest_step = std::max(result.largest_step, (force - before).norm() / ticks);
        result.forces.push_back(force.norm());
        const bool is_full = force_scale == 1 && servo.fade_factor() == 1;
        result.in_full.push_back(is_full && tick > 0 ? result.in_full.back() + 1 : 0);
        hand.step(force, target);
    }
    return result;
}

struct LoopbackResult {
    bool began_outside = false; ///< the session heard of the hand before it was in the cube
    HandOverLine hand;
    SessionResult session;
    UdpReport report;
};

LoopbackResult loopback(const Line& line, int ms, bool own_servo)
{
    const CubeScene scene;
    const auto device = listening_device();
    LoopbackResult result;
    std::thread hand(
        [&] { result.hand = hand_over_line(device->address(), scene, line, ms, own_servo); });
    result.session =
        run_session(scene, *device, static_cast<std::uint64_t>(ms), {}, {}, Pace::best_effort);
    hand.join();
    for (const RecordedTick& tick : result.session.recording.ticks) {
        if (!std::isfinite(tick.position[2])) continue;
        result.began_outside = tick.position[2] > scene.half;
        break;
    }
    result.report = device->report();
    return result;
}

/// Expects the force of a hand at rest.
void expect_rest(const HandOverLine& hand, std::size_t tick)
{
    EXPECT_NEAR(hand.forces[tick], force_at_rest(), left_of_motion(hand.in_full[tick])) << tick;
}
void expect_rest_at_end(const HandOverLine& hand)
{
    expect_rest(hand, hand.forces.size() - 1);
}

/// Whether the hand came from outside, the force was given in full for so long that little is left
/// of the hand's motion, at the end and before the line is cut, and nothing interrupted its return.
bool is_steady(const LoopbackResult& result, const Line& line)
{
    constexpr int at_end = 300;     // 0.14 N are left
    constexpr int before_cut = 200; // 0.6 N
    const std::vector<int>& in_full = result.hand.in_full;
    if (line.cut_from > 0 && in_full[static_cast<std::size_t>(line.cut_from) - 1] < before_cut)
        return false;
    return result.began_outside && in_full.back() >= at_end &&
           result.session.input.longest_recovery < 2 * ForceOptions{}.loss_seconds;
}

/// Tries again where a busy machine has begun late, or kept the line silent for longer than its
/// patience.
LoopbackResult steady_loopback(const Line& line, int ms, bool own_servo)
{
    LoopbackResult result;
    for (int attempt = 0; attempt < 5; ++attempt) {
        result = loopback(line, ms, own_servo);
        if (is_steady(result, line)) break;
    }
    EXPECT_TRUE(is_steady(result, line));
    return result;
}

TEST(UdpSession, AHandFeelsTheSurfaceOverLoopback)
{
    for (const bool own_servo : {false, true}) {
        const LoopbackResult result = steady_loopback({}, 800, own_servo);
        EXPECT_GT(result.report.accepted, 100U); // of 800, on a machine that does other things
        EXPECT_GT(result.hand.replies, 100U);
        EXPECT_EQ(result.report.malformed + result.report.foreign + result.report.unsent, 0U);
        SCOPED_TRACE(own_servo ? "a servo of its own" : "the forces of the replies");
        expect_rest_at_end(result.hand);
        EXPECT_EQ(result.session.quality.passes, 0U);
    }
}

TEST(UdpSession, TwoHandsFeelAtOnce)
{
    LoopbackResult left;
    LoopbackResult right;
    std::thread other([&] { left = steady_loopback({}, 800, true); });
    right = steady_loopback({}, 800, false);
    other.join();
    for (const LoopbackResult* const result : {&left, &right}) {
        EXPECT_EQ(result->report.foreign, 0U);
        expect_rest_at_end(result->hand);
    }
}

TEST(UdpSession, ABadLineCausesNoForceSpikes)
{
    const LoopbackResult result =
        steady_loopback({.lose = 0.2, .twice = 0.2, .swap = 0.2}, 1200, true);
    EXPECT_GT(result.report.duplicated, 20U);
    EXPECT_GT(result.report.reordered, 20U);
    EXPECT_GT(result.report.lost, 20U);
    expect_rest_at_end(result.hand);
    EXPECT_LT(result.hand.largest_step, largest_change());
}

TEST(UdpSession, ACutLineFadesTheForceOnBothSidesAndRecovers)
{
    const LoopbackResult result = steady_loopback({.cut_from = 700, .cut_to = 1000}, 1600, true);
    expect_rest(result.hand, 699);
    // The device's side: 20 ms of holding and 50 of fading, by its own clock.
    for (std::size_t tick = 780; tick < 1000; ++tick)
        EXPECT_EQ(result.hand.forces[tick], 0) << tick;
    expect_rest_at_end(result.hand);
    EXPECT_LT(result.hand.largest_step, largest_change());
    EXPECT_GE(result.session.input.silences, 1U);
    EXPECT_GE(result.session.input.recoveries, 1U);
    // 300 ms less the patience, and less what a busy machine leaves out.
    EXPECT_GE(result.session.input.longest_fault, 0.2);
    EXPECT_LT(result.session.input.longest_recovery, 2 * ForceOptions{}.loss_seconds);
}

} // namespace
} // namespace proxima::udp_session_test
