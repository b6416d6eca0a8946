// The passivity guard on surfaces that move: what they carry may swing, what they shake does not.
#include "haptics/force/carried_frame.h"

#include "haptics/force/surface_renderer.h"
#include "haptics/scenes_to_touch.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>

namespace proxima::carried_frame_test {
namespace {

using namespace testing;

constexpr double tick_seconds = 1e-3;

using Height = std::function<double(double seconds)>; ///< m

Height shaking(double amplitude, double per_second)
{
    return [=](double seconds) {
        return amplitude * std::sin(2 * std::numbers::pi * per_second * seconds);
    };
}

struct Felt {
    double greatest = 0; ///< N, after half a second, as all that follows
    double work = 0;     ///< J, given to the device
    double swing = 0; ///< m: between the highest and the lowest place above the surface at the end
    SwingReport guard;
};

struct Wall {
    const char* device = "omni";
    double stiffness = 300; ///< N/m
    double damping = 1;     ///< N s/m
    Height height;          ///< of its surface
};

/// A device that a hand pulls to that height, or that stands still.
Felt touch(const Wall& wall, const std::optional<HandModel>& hand, const Height& home, Guard guard)
{
    TouchScene scene(wide_room);
    const auto box = scene.add(body_of(box_mesh(Vec3(1, 1, 0.1))), at_place(Vec3(0, 0, -0.1)));
    RenderOptions options;
    options.force.stiffness = wall.stiffness;
    options.force.damping = wall.damping;
    options.guard = guard;
    const DeviceLimits device = *find_device(wall.device);
    HapticRenderer renderer = make_haptic_renderer(scene, WorkspaceMap{}, device, options).value();
    const auto where = [&](double above) { return Vec3(0.01, 0.013, above); };
    SimulatedHand held(hand.value_or(HandModel{}), where(5e-4));
    Felt felt;
    double lowest = 1;
    double highest = -1;
    const int ticks = 3000;
    for (int tick = 0; tick < ticks; ++tick) {
        const double top = wall.height(tick * tick_seconds);
        const ObjectMotion move = {.pose = at_place(Vec3(0, 0, top - 0.1)),
                                   .seconds = tick_seconds};
        EXPECT_TRUE(scene.move(*box, move));
        DeviceState state;
        state.pose.translation = where(5e-4);
        if (hand) state = held.state();
        const Vec3 force = renderer.tick(state, tick_seconds).force;
        if (hand) held.step(force, where(home(tick * tick_seconds)));
        if (tick < 500) continue;
        felt.greatest = std::max(felt.greatest, force.norm());
        if (hand) felt.work += force.dot(held.velocity()) * tick_seconds;
        if (tick < ticks - 500) continue;
        lowest = std::min(lowest, held.position().z() - top);
        highest = std::max(highest, held.position().z() - top);
    }
    felt.swing = highest - lowest;
    felt.guard = parts_of(renderer).passivity().report();
    return felt;
}

TEST(CarriedFrame, FollowsALiftAndNotWhatShakes)
{
    using Step = Eigen::Matrix<double, 1, 1>;
    const auto way_of = [](const Height& height) {
        CarriedFrame<1> frame;
        double lowest = 0;
        double highest = 0;
        double way = 0;
        for (int tick = 1; tick <= 3000; ++tick) {
            const Step surface(height(tick * tick_seconds) - height((tick - 1) * tick_seconds));
            way += frame.step(&surface, tick_seconds).value();
            if (tick <= 1000) continue;
            lowest = tick == 1001 ? way : std::min(lowest, way);
            highest = tick == 1001 ? way : std::max(highest, way);
        }
        return highest - lowest;
    };
    EXPECT_NEAR(way_of([](double seconds) { return 0.1 * seconds; }), 0.2, 0.005);
    EXPECT_LT(way_of(shaking(1, 2)), 2.0 / 3);
    EXPECT_LT(way_of(shaking(1, 20)), 0.1);
    CarriedFrame<1> frame;
    const Step surface(1e-3);
    for (int tick = 0; tick < 1000; ++tick) (void)frame.step(&surface, tick_seconds);
    for (int tick = 0; tick < 249; ++tick) // it bounces
        EXPECT_NEAR(frame.step(nullptr, tick_seconds).value(), 1e-3, 1e-4);
    for (int tick = 0; tick < 3; ++tick) (void)frame.step(nullptr, tick_seconds);
    EXPECT_EQ(frame.step(nullptr, tick_seconds).value(), 0);
}

TEST(PassivityGuard, LeavesADeviceAloneThatASurfaceShakes)
{
    HandModel hand;
    hand.hand_damping = 5.5;
    const Height home = [](double) { return -2e-3; }; // below the middle of the surface
    for (const char* device : {"omni", "delta"}) {
        for (const double stiffness : {300.0, 700.0}) {
            for (const double amplitude : {5e-4, 3e-3}) {
                for (const double rate : {2.0, 3.0, 5.0, 20.0, 30.0, 50.0, 120.0}) {
                    const Wall wall = {device, stiffness, 1, shaking(amplitude, rate)};
                    const std::string where =
                        std::string(device) + ' ' + std::to_string(stiffness) + " N/m, " +
                        std::to_string(amplitude) + " m, " + std::to_string(rate) + " Hz";
                    const Felt fixed = touch(wall, std::nullopt, home, Guard::on);
                    EXPECT_EQ(fixed.greatest, touch(wall, std::nullopt, home, Guard::off).greatest)
                        << where;
                    EXPECT_EQ(fixed.guard.swings + fixed.guard.softenings, 0U) << where;
                    const Felt on = touch(wall, hand, home, Guard::on);
                    const Felt off = touch(wall, hand, home, Guard::off);
                    EXPECT_LE(on.greatest, 1.1 * off.greatest) << where;
                    EXPECT_LE(on.work, 1.1 * off.work + 1e-4) << where;
                    EXPECT_EQ(on.guard.softenings, 0U) << where;
                }
            }
        }
    }
}

/// A device whose forces are late swings on a lift as on a surface at rest, and is damped alike.
TEST(PassivityGuard, DampsASwingOnALiftAsOnTheGround)
{
    HandModel hand;
    hand.delay_ticks = 3;
    hand.hand_damping = 0;
    for (const double speed : {0.0, 0.02, 0.1}) { // m/s
        const Wall wall = {"omni", 700, 0, [=](double seconds) { return speed * seconds; }};
        const Height home = [=](double seconds) { return speed * seconds - 1e-3; };
        const Felt off = touch(wall, hand, home, Guard::off);
        const Felt on = touch(wall, hand, home, Guard::on);
        EXPECT_GT(off.swing, 3e-3) << speed;
        EXPECT_LT(on.swing, 1e-3) << speed;
        EXPECT_GT(on.guard.swings, 0U) << speed;
    }
}

} // namespace
} // namespace proxima::carried_frame_test
