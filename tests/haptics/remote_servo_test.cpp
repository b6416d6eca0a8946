#include "haptics/device/remote_servo.h"

#include "haptics/device_session.h"
#include "haptics/force/surface_renderer.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

namespace proxima::remote_servo_test {
namespace {

using testing::CubeScene;

TEST(RemoteServo, GivesTheForceOfTheRenderer)
{
    // A hand slides over the cube with a reply every tick: both sides' forces are the same, but for
    // the way of a tick; with a reply every 10 ms it is still the wall's.
    for (const int every : {1, 10}) {
        const CubeScene scene;
        HapticRenderer renderer =
            make_surface_renderer(scene.surface, scene.map, *find_device("omni"));
        DeviceInput input = make_device_input({}).value();
        RemoteServo servo(3.3);
        double largest = 0;
        for (int tick = 0; tick < 2000; ++tick) {
            const double t = 1e-3 * tick;
            DeviceReading reading;
            reading.sample = static_cast<std::uint64_t>(tick) + 1;
            Vec3& place = reading.state.pose.translation;
            place = Vec3(0.01 * std::sin(3 * t), 0.01 * std::cos(2 * t),
                         scene.half + std::max(0.01 - 0.05 * t, -0.004));
            const RenderTick& rendered = renderer.tick(input.accept(reading), 1e-3);
            ReplyPacket reply;
            reply.sequence = reading.sample;
            reply.command = input.command(renderer);
            reply.max_force = 3.3;
            reply.hold_seconds = 0.02;
            reply.fade_seconds = 0.05;
            reply.recovery_seconds = 0.01;
            if (tick % every == 0) servo.take(reply, t);
            const Vec3 force = servo.force(place, reading.state.velocity, t);
            if (tick > 500) largest = std::max(largest, (force - rendered.force).norm());
        }
        EXPECT_LT(largest, every == 1 ? 0.05 : 0.15);
        EXPECT_EQ(servo.fade_factor(), 1);
        EXPECT_EQ(servo.refused(), 0U);
    }
}

TEST(RemoteServo, DampsAsTheRendererDoes)
{
    // A hand that trembles on the cube, 1 to 3 mm deep, with a reply every tick.
    const CubeScene scene;
    RenderOptions options;
    options.force.damping = 5;
    options.static_friction = options.dynamic_friction = 0;
    options.guard = Guard::off;
    HapticRenderer renderer =
        make_surface_renderer(scene.surface, scene.map, *find_device("omni"), options);
    DeviceInput input = make_device_input({}).value();
    RemoteServo servo(3.3);
    double largest = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        const double t = 1e-3 * tick;
        const double height = tick < 100 ? 0.001 : -0.002 + 0.001 * std::sin(50 * t);
        const double speed = tick < 100 ? 0 : 0.05 * std::cos(50 * t);
        DeviceReading reading;
        reading.sample = static_cast<std::uint64_t>(tick) + 1;
        reading.state.pose.translation = Vec3(0.01, 0.02, scene.half + height);
        reading.state.velocity = Vec3(0, 0, speed);
        renderer.tick(input.accept(reading), 1e-3);
        ReplyPacket reply;
        reply.sequence = reading.sample;
        reply.command = input.command(renderer);
        reply.max_force = 3.3;
        reply.hold_seconds = 0.02;
        reply.recovery_seconds = 0.01;
        servo.take(reply, t);
        const Vec3 force = servo.force(reading.state.pose.translation, reading.state.velocity, t);
        if (tick < 500) continue; // ramps are over
        const Vec3 expected(0, 0, -500 * height - 5 * speed);
        EXPECT_LT((renderer.last().force - expected).norm(), 1e-5) << tick;
        largest = std::max(largest, (force - expected).norm());
    }
    EXPECT_LT(largest, 1e-5);
}

TEST(RemoteServo, ChangesToNewPlanesWithoutAJump)
{
    RemoteServo servo(3.3);
    ReplyPacket reply;
    reply.max_force = 3.3;
    reply.hold_seconds = 10;
    reply.recovery_seconds = 0.02;
    reply.command.stiffness = 500;
    reply.command.plane_count = 1;
    reply.command.planes[0] = {Vec3::UnitZ(), 0};
    servo.take(reply, 0);
    const Vec3 place(0, 0, -0.001);
    double t = 0;
    for (; t < 0.1; t += 1e-3) (void)servo.force(place, Vec3::Zero(), t);
    EXPECT_NEAR(servo.force(place, Vec3::Zero(), t).z(), 0.5, 1e-12);
    reply.sequence = 1;
    reply.command.planes[0].offset = 0.004; // all at once 4 mm deeper
    servo.take(reply, t);
    double last = 0.5;
    for (int tick = 0; tick <= 25; ++tick) {
        const double force = servo.force(place, Vec3::Zero(), t + 1e-3 * tick).z();
        EXPECT_LE(force - last, 2.0 / 20 + 1e-9) << tick;
        EXPECT_GE(force, last - 1e-12);
        last = force;
    }
    EXPECT_NEAR(last, 2.5, 1e-12);
}

/// A wall at z = 0 of 500 N/m.
ReplyPacket wall_reply(std::uint64_t sequence)
{
    ReplyPacket reply;
    reply.sequence = sequence;
    reply.max_force = 3.3;
    reply.hold_seconds = 10;
    reply.command.force_scale = 1;
    reply.command.stiffness = 500;
    reply.command.plane_count = 1;
    reply.command.planes[0] = {Vec3::UnitZ(), 0};
    return reply;
}

/// What a tip 2 mm behind z = 0 feels once nothing fades any more.
double settled_force(RemoteServo& servo)
{
    double force = 0;
    for (double t = 0; t < 0.1; t += 1e-3)
        force = servo.force(Vec3(0, 0, -0.002), Vec3::Zero(), t).z();
    return force;
}

TEST(RemoteServo, TakesNewRepliesAndRefusesOldOnes)
{
    RemoteServo servo(3.3);
    servo.take(wall_reply(7), 0);
    EXPECT_NEAR(settled_force(servo), 1, 1e-12);
    ReplyPacket old = wall_reply(6);
    old.command.stiffness = 100;
    servo.take(old, 0);
    EXPECT_EQ(servo.refused(), 1U);
    EXPECT_NEAR(settled_force(servo), 1, 1e-12);
    old.session = 1; // of another session, which begins anew
    servo.take(old, 0);
    EXPECT_EQ(servo.refused(), 1U);
    EXPECT_NEAR(settled_force(servo), 0.2, 1e-12);
}

TEST(RemoteServo, ARepeatedReplyIsNotOld)
{
    // It says that the renderer is alive: the time for which it holds begins anew.
    RemoteServo servo(3.3);
    ReplyPacket reply = wall_reply(7);
    reply.hold_seconds = 0.25;
    servo.take(reply, 0);
    servo.take(reply, 0.25);
    EXPECT_EQ(servo.refused(), 0U);
    EXPECT_NEAR(servo.force(Vec3(0, 0, -0.002), Vec3::Zero(), 0.5).z(), 1, 1e-12);
}

TEST(RemoteServo, HoldsAReplyForItsTimeExactly)
{
    RemoteServo servo(3.3);
    ReplyPacket reply = wall_reply(1);
    reply.hold_seconds = 0.25;
    servo.take(reply, 1);
    const auto force = [&](double now) {
        return servo.force(Vec3(0, 0, -0.002), Vec3::Zero(), now).z();
    };
    EXPECT_NEAR(force(1), 1, 1e-12);
    EXPECT_NEAR(force(1.25), 1, 1e-12);
    EXPECT_EQ(force(std::nextafter(1.25, 2.0)), 0);
}

TEST(RemoteServo, FadesInAndOutOverItsFadingTime)
{
    // 64 ticks in, 64 out once the reply no longer holds, whatever the clock says at the start.
    for (const double start : {0.0, 1000.0}) {
        RemoteServo servo(3.3);
        ReplyPacket reply = wall_reply(1);
        constexpr double tick = 0x1p-10;
        reply.hold_seconds = 100 * tick;
        reply.fade_seconds = 64 * tick;
        (void)servo.force(Vec3::Zero(), Vec3::Zero(), start); // nothing was received
        EXPECT_EQ(servo.fade_factor(), 0);
        servo.take(reply, start);
        for (int i = 1; i <= 200; ++i) {
            const double force =
                servo.force(Vec3(0, 0, -0.002), Vec3::Zero(), start + i * tick).z();
            const double wanted = std::max(0.0, std::min(i, 64 - std::max(i - 100, 0)) / 64.0);
            EXPECT_EQ(servo.fade_factor(), wanted) << start << ' ' << i;
            EXPECT_NEAR(force, wanted, 1e-12) << start << ' ' << i;
        }
    }
}

TEST(RemoteServo, SticksUpToTheConeOfStaticFriction)
{
    // The tip is 1/512 m deep. Its anchor is as far aside as the static friction holds, or farther.
    const auto aside_force = [](double aside) {
        RemoteServo servo(100);
        ReplyPacket reply = wall_reply(1);
        reply.max_force = 100;
        reply.command.stiffness = 512;
        reply.command.static_friction = 0.5;
        reply.command.dynamic_friction = 0.25;
        reply.command.anchor = Vec3(aside, 0, 0);
        servo.take(reply, 0);
        return servo.force(Vec3(0, 0, -0x1p-9), Vec3::Zero(), 0).x();
    };
    EXPECT_EQ(aside_force(0x1p-10), 0.5);                                // static, of 1 N
    EXPECT_NEAR(aside_force(std::nextafter(0x1p-10, 1.0)), 0.25, 1e-12); // slides: dynamic
    EXPECT_EQ(aside_force(0x1p-12), 0.125);
}

TEST(RemoteServo, ANanometreOfDepthIsNotFelt)
{
    const auto force_at = [](double depth) {
        RemoteServo servo(3.3);
        servo.take(wall_reply(1), 0);
        return servo.force(Vec3(0, 0, -depth), Vec3::Zero(), 0).z();
    };
    EXPECT_EQ(force_at(0.9e-9), 0);
    EXPECT_NEAR(force_at(1.1e-9), 500 * 1.1e-9, 1e-12);
}

TEST(RemoteServo, StaysWithinBothLimits)
{
    RemoteServo strong(3.3);
    ReplyPacket reply = wall_reply(1);
    reply.max_force = 0.5;
    strong.take(reply, 0);
    EXPECT_NEAR(settled_force(strong), 0.5, 1e-9);
    RemoteServo weak(0.25);
    weak.take(reply, 0);
    EXPECT_NEAR(settled_force(weak), 0.25, 1e-9);
}

TEST(RemoteServo, RefusesNumbersJustBeyondWhatIsSound)
{
    const auto is_refused = [](const auto& change) {
        RemoteServo servo(3.3);
        ReplyPacket reply = wall_reply(1);
        change(reply);
        servo.take(reply, 0);
        return servo.refused() == 1;
    };
    const double beyond = std::nextafter(1e6, 2e6);
    EXPECT_FALSE(is_refused([](ReplyPacket& r) { r.command.force_scale = 1; }));
    EXPECT_TRUE(
        is_refused([](ReplyPacket& r) { r.command.force_scale = std::nextafter(1.0, 2.0); }));
    EXPECT_FALSE(is_refused([](ReplyPacket& r) { r.command.stiffness = 1e6; }));
    EXPECT_TRUE(is_refused([&](ReplyPacket& r) { r.command.stiffness = beyond; }));
    EXPECT_FALSE(is_refused([](ReplyPacket& r) { r.command.damping = 0; }));
    EXPECT_TRUE(is_refused([](ReplyPacket& r) { r.command.damping = -1e-300; }));
    EXPECT_FALSE(is_refused([](ReplyPacket& r) { r.command.force.x() = -1e6; }));
    EXPECT_TRUE(is_refused([&](ReplyPacket& r) { r.command.force.x() = -beyond; }));
    EXPECT_FALSE(is_refused([](ReplyPacket& r) { r.command.planes[0].offset = -1e6; }));
    EXPECT_TRUE(is_refused([&](ReplyPacket& r) { r.command.planes[0].offset = -beyond; }));
    EXPECT_TRUE(is_refused([](ReplyPacket& r) { r.command.planes[0].normal.z() = 1 + 2e-6; }));
    EXPECT_FALSE(is_refused([](ReplyPacket& r) { r.command.planes[0].normal.z() = 1 + 5e-7; }));
    EXPECT_FALSE(
        is_refused([](ReplyPacket& r) { r.command.planes[1].normal.x() = NAN; })); // unused
}

TEST(RemoteServo, RefusesHostileReplies)
{
    std::mt19937_64 random(9);
    RemoteServo servo(3.3);
    for (int round = 0; round < 100000; ++round) {
        ReplyPacket reply;
        reply.command.plane_count = random() % 4;
        const auto any = [&] {
            const double x = std::bit_cast<double>(random());
            return random() % 3 == 0 ? x : static_cast<double>(random() % 1000) / 100;
        };
        reply.sequence = random() % 2 == 0 ? static_cast<std::uint64_t>(round) : random();
        for (DevicePlane& plane : reply.command.planes) {
            plane.normal = random() % 4 == 0 ? Vec3{any(), any(), any()} : Vec3(Vec3::UnitX());
            plane.offset = any();
        }
        for (double* const x :
             {&reply.command.force_scale, &reply.command.stiffness, &reply.command.damping,
              &reply.command.static_friction, &reply.command.dynamic_friction, &reply.max_force,
              &reply.hold_seconds, &reply.fade_seconds, &reply.recovery_seconds})
            *x = random() % 2 == 0 ? any() : 1.0;
        servo.take(reply, 1e-3 * round);
        const Vec3 force = servo.force(Vec3{any(), any(), any()}, Vec3(any(), 0, 0), 1e-3 * round);
        ASSERT_TRUE(force.allFinite()) << round;
        ASSERT_LE(force.norm(), 3.3) << round;
    }
    EXPECT_GT(servo.refused(), 1000U);
}

} // namespace
} // namespace proxima::remote_servo_test
