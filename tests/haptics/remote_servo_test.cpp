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

namespace proxima {
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
} // namespace proxima
