#include "lab/simulated_hand.h"

#include "haptics/force/passivity.h"
#include "haptics/theory_wall.h"
#include "proxima/device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace proxima::simulated_hand_test {
namespace {

using testing::stiffness_limit;
using testing::theory_swing;
using testing::TheoryWall;
using testing::without_hand;

TEST(SimulatedHand, HasTheStabilityLimitsOfTheory)
{
    HandModel model = without_hand();
    EXPECT_NEAR(stiffness_limit(model, 0), 0.5 / 0.0005, 0.02 * 1000);
    model.delay_ticks = 1;
    EXPECT_NEAR(stiffness_limit(model, 0), 0.5 / 0.0015, 0.02 * 333.3);
    model.delay_ticks = 0;
    model.tick_seconds = 0.01;
    EXPECT_NEAR(stiffness_limit(model, 0), 0.5 / 0.005, 0.02 * 100);
    model.tick_seconds = 0.001;
    model.device_damping = 0.1;
    EXPECT_NEAR(stiffness_limit(model, 1), 1.1 / 0.0005, 0.02 * 2200);
    model.velocity = VelocityEstimate::exact;
    EXPECT_NEAR(stiffness_limit(model, 1), 1.1 / 0.0005, 0.02 * 2200);
}

TEST(SimulatedHand, FrictionStopsEncoderLimitCyclesUpToTheStiffnessOfTheory)
{
    HandModel model = without_hand();
    model.device_damping = 0.5;
    model.encoder_step = 5e-5;
    model.coulomb_friction = 0.02;
    const double limit = 2 * model.coulomb_friction / model.encoder_step; // 800 N/m
    ASSERT_LT(limit, 2 * model.device_damping / model.tick_seconds);
    EXPECT_LT(theory_swing(model, {0.9 * limit, 0}, 20000), 2 * model.encoder_step);
    SimulatedHand hand(model, Vec3(1e-3, 0, 0));
    for (int tick = 0; tick < 20000; ++tick)
        hand.step(TheoryWall{0.9 * limit, 0}.force(hand.state()), Vec3::Zero());
    EXPECT_EQ(hand.velocity(), Vec3::Zero()); // at rest, not in a cycle
}

TEST(SimulatedHand, FollowsItsEquationOfMotion)
{
    // Against many small steps of the midpoint rule.
    const HandModel model;
    SimulatedHand hand(model, Vec3(0.01, -0.02, 0.03));
    const Vec3 target(0.02, 0.01, -0.01);
    const Vec3 force(0.3, -0.2, 0.1);
    Vec3 x = hand.position();
    Vec3 v = Vec3::Zero();
    const auto acceleration = [&](const Vec3& at, const Vec3& speed) {
        return Vec3((force + model.hand_stiffness * (target - at) -
                     (model.hand_damping + model.device_damping) * speed) /
                    model.mass);
    };
    for (int tick = 0; tick < 50; ++tick) {
        hand.step(force, target);
        constexpr int parts = 1000;
        const double h = model.tick_seconds / parts;
        for (int i = 0; i < parts; ++i) {
            const Vec3 middle_v = v + h / 2 * acceleration(x, v);
            const Vec3 middle_x = x + h / 2 * v;
            x += h * middle_v;
            v += h * acceleration(middle_x, middle_v);
        }
        EXPECT_LT((hand.position() - x).norm(), 1e-10) << tick;
        EXPECT_LT((hand.velocity() - v).norm(), 1e-8) << tick;
    }
}

TEST(SimulatedHand, ReportsEncoderReadings)
{
    HandModel model = without_hand();
    model.encoder_step = 1e-4;
    model.device_damping = 0;
    SimulatedHand hand(model, Vec3(0.00012, 0, 0));
    EXPECT_NEAR(hand.state().pose.translation.x(), 1e-4, 1e-18);
    hand.set_motion(Vec3(0.00012, 0, 0), Vec3(0.05, 0, 0));
    hand.step(Vec3::Zero(), Vec3::Zero());
    EXPECT_NEAR(hand.position().x(), 0.00017, 1e-15);
    EXPECT_NEAR(hand.state().pose.translation.x(), 2e-4, 1e-18);
    EXPECT_NEAR(hand.state().velocity.x(), 0.1, 1e-12); // two steps for one and a half
}

TEST(SimulatedHand, FeelsForcesAfterTheDelay)
{
    HandModel model = without_hand();
    model.device_damping = 0;
    model.delay_ticks = 3;
    SimulatedHand hand(model, Vec3::Zero());
    for (int tick = 0; tick < 6; ++tick) {
        hand.step(tick == 0 ? Vec3(1, 0, 0) : Vec3(0, 0, 0), Vec3::Zero());
        EXPECT_EQ(hand.velocity().x() > 0, tick >= 3) << tick;
    }
}

/// Swings against a wall with the passivity guard between.
struct Guarded {
    double largest = 0; ///< |x| of the last tenth
    SwingReport report;
};

Guarded guarded_swing(const HandModel& model, const TheoryWall& wall, double max_damping,
                      Guard mode = Guard::on)
{
    SimulatedHand hand(model, Vec3(1e-3, 0, 0));
    PassivityGuard guard(mode, {.max_force = 1e9, .max_damping = max_damping});
    Guarded result;
    constexpr int ticks = 20000;
    for (int tick = 0; tick < ticks; ++tick) {
        const DeviceState state = hand.state();
        const TheoryWall spring{wall.stiffness, 0};
        const Vec3 force =
            guard.pass(state.pose.translation, state.velocity,
                       {spring.force(state), wall.force(state), wall.damping}, model.tick_seconds);
        hand.step(force, Vec3::Zero());
        if (tick >= ticks - ticks / 10)
            result.largest = std::max(result.largest, std::abs(hand.position().x()));
        if (!(std::abs(hand.position().x()) < 1)) {
            result.largest = 1;
            break;
        }
    }
    result.report = guard.report();
    return result;
}

TEST(PassivityGuard, CatchesWallsThatAreTooStiff)
{
    HandModel model = without_hand();
    for (const double factor : {1.2, 1.5, 2.0, 3.0}) {
        const TheoryWall wall{factor * 1000, 0};
        EXPECT_GT(theory_swing(model, wall, 20000), 1e-2) << factor; // it would have grown
        const Guarded guarded = guarded_swing(model, wall, 30);
        EXPECT_LT(guarded.largest, 1.5e-3) << factor;
        EXPECT_GT(guarded.report.damped_ticks, 0U) << factor;
    }
    model.delay_ticks = 1;
    EXPECT_GT(theory_swing(model, {500, 0}, 20000), 1e-2);
    EXPECT_LT(guarded_swing(model, {500, 0}, 30).largest, 1.5e-3);
}

TEST(PassivityGuard, CatchesSwingsThatTheLargestDampingOfADeviceCannot)
{
    struct Setting {
        double stiffness;
        double b;
        double max_damping;
    };
    for (const auto& [stiffness, b, max_damping] :
         {Setting{700, 0.5, 5}, Setting{700, 0.5, 30}, Setting{400, 0.1, 4}, Setting{400, 0.1, 30},
          Setting{5000, 0.1, 30}}) {
        for (int delay = 1; delay <= 3; ++delay) {
            HandModel model = without_hand();
            model.device_damping = b;
            model.delay_ticks = delay;
            EXPECT_GT(theory_swing(model, {stiffness, 0}, 20000), 1e-2);
            EXPECT_LT(guarded_swing(model, {stiffness, 0}, max_damping).largest, 1e-3)
                << stiffness << ' ' << b << ' ' << max_damping << ' ' << delay;
        }
    }
}

TEST(PassivityGuard, LeavesStableWallsAlone)
{
    const Guarded guarded = guarded_swing(without_hand(), {300, 0}, 30);
    EXPECT_LT(guarded.largest, 1e-6);
    EXPECT_EQ(guarded.report.damped_ticks, 0U);
}

TEST(PassivityGuard, ObservesWithoutTouchingTheForce)
{
    // A wall that swings: observed, it leaves as it does unguarded, and the report has what the guard
    // would have done.
    HandModel model = without_hand();
    model.delay_ticks = 3;
    EXPECT_EQ(guarded_swing(model, {700, 0}, 5, Guard::off).report.swings, 0U);
    const Guarded observed = guarded_swing(model, {700, 0}, 5, Guard::observe);
    EXPECT_EQ(observed.largest, 1);
    EXPECT_GT(observed.report.swings, 0U);
    EXPECT_GT(observed.report.most_given, 0);
}

TEST(PassivityGuard, StartsAnewAndRecoversWithinSeconds)
{
    HandModel model = without_hand();
    model.delay_ticks = 3;
    SimulatedHand hand(model, Vec3(1e-3, 0, 0));
    PassivityGuard guard(Guard::on, {.max_force = 1e9, .max_damping = 0});
    const auto swing_until_softened = [&] {
        for (int tick = 0; tick < 2000 && guard.softness() > 0.3; ++tick) {
            const DeviceState state = hand.state();
            const Vec3 force = -700 * state.pose.translation;
            hand.step(
                guard.pass(state.pose.translation, state.velocity, {force, force, 700, 0}, 1e-3),
                Vec3::Zero());
        }
        EXPECT_LT(guard.softness(), 0.3);
    };
    swing_until_softened();
    guard.reset();
    EXPECT_EQ(guard.softness(), 1);
    EXPECT_EQ(guard.report().softenings, 0U);
    hand.set_motion(Vec3(1e-3, 0, 0), Vec3::Zero());
    swing_until_softened();
    int ticks = 0;
    for (; guard.softness() < 1 && ticks < 20000; ++ticks)
        (void)guard.pass(Vec3(1, 0, 0), Vec3::Zero(), {}, 1e-3);
    // A contact is over after 0.25 s; from a fifth, doubling in four seconds, takes 9.29 s.
    EXPECT_LE(ticks, 250 + 9289);
    EXPECT_GT(ticks, 6500);
}

} // namespace
} // namespace proxima::simulated_hand_test
