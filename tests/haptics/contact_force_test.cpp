#include "haptics/force/contact_force.h"

#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>

namespace proxima::contact_force_test {
namespace {

constexpr double tick = 1e-3;

ForceOptions without_ramps()
{
    return {.max_slew = 1e9, .start_seconds = 0, .loss_seconds = 0};
}

TEST(SpringForce, IsASpringAndADamperAlongTheNormal)
{
    const ForceOptions options = {.stiffness = 500, .damping = 2};
    const SpringContact contact = {true, Vec3(0.001, 0, 0.002), Vec3::UnitZ()};
    EXPECT_LT((spring_force(options, contact, Vec3(0.3, 0.2, -0.1)) - Vec3(0.5, 0, 1.2)).norm(),
              1e-15);
    EXPECT_EQ(spring_force(options, {}, Vec3(1, 1, 1)), Vec3::Zero());
    // Leaving fast, it lets go, but does not hold back.
    EXPECT_LT((spring_force(options, contact, Vec3(0, 0, 9)) - Vec3(0.5, 0, 0)).norm(), 1e-15);
}

TEST(SpringForce, PenaltyIsZeroOutside)
{
    const ForceOptions options = {.stiffness = 400, .damping = 0};
    EXPECT_EQ(penalty_force(options, -0.001, Vec3::UnitX(), Vec3::Zero()), Vec3::Zero());
    EXPECT_LT((penalty_force(options, 0.002, Vec3::UnitX(), Vec3::Zero()) - Vec3(0.8, 0, 0)).norm(),
              1e-15);
}

TEST(ForceGuard, GivesFiniteForcesWithinLimitsForAnyInput)
{
    const double infinity = std::numeric_limits<double>::infinity();
    const std::array special = {infinity, -infinity, std::numeric_limits<double>::quiet_NaN(),
                                1e308,    -1e308,    1e-320,
                                0.0,      3.3};
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    for (const double most : {3.3, 1e-3, 20.0}) {
        ForceGuard guard({.max_slew = 700}, most);
        Vec3 last = Vec3::Zero();
        for (int i = 0; i < 100000; ++i) {
            Vec3 wanted = 5 * Vec3{normal(random), normal(random), normal(random)};
            if (random() % 3 == 0) wanted[random() % 3] = special[random() % special.size()];
            const double seconds =
                random() % 20 == 0 ? special[random() % special.size()] : tick * normal(random);
            const Vec3 force =
                guard.pass(wanted, seconds, random() % 5 == 0 ? Patch::lost : Patch::available);
            ASSERT_TRUE(force.allFinite());
            ASSERT_LE(force.norm(), most);
            if (std::isfinite(seconds) && seconds < 1) {
                ASSERT_LE((force - last).norm(), 700 * std::max(seconds, 0.0) + 1e-14 * most);
            }
            last = force;
        }
        EXPECT_GT(guard.refused(), 0U);
        EXPECT_GT(guard.clamped(), 0U);
        EXPECT_GT(guard.slewed(), 0U);
    }
}

TEST(ForceGuard, PassesForcesWithinItsLimits)
{
    ForceGuard guard(without_ramps(), 3.3);
    for (const Vec3& force : {Vec3(1, 2, -2), Vec3(0, 0, 0), Vec3(0, 3.3, 0)})
        EXPECT_EQ(guard.pass(force, tick), force);
    EXPECT_EQ(guard.clamped() + guard.slewed() + guard.refused(), 0U);
    EXPECT_NEAR(guard.pass(Vec3(30, 40, 0), tick).norm(), 3.3, 1e-12);
    EXPECT_NEAR(guard.last().y() / guard.last().x(), 4.0 / 3, 1e-12);
}

TEST(ForceGuard, CountsEachForceThatItChanges)
{
    ForceOptions options = without_ramps();
    options.max_slew = 1000; // 1 N in a tick
    ForceGuard guard(options, 2);
    EXPECT_EQ(guard.pass(Vec3(5, 0, 0), tick), Vec3(1, 0, 0)); // 2 N in two ticks
    EXPECT_EQ(guard.clamped(), 1U);
    EXPECT_EQ(guard.slewed(), 1U);
    EXPECT_EQ(guard.pass(Vec3(7, 0, 0), tick), Vec3(2, 0, 0));
    EXPECT_EQ(guard.clamped(), 2U);
    EXPECT_EQ(guard.slewed(), 1U);
    const Vec3 nothing(std::numeric_limits<double>::quiet_NaN(), 0, 0);
    EXPECT_EQ(guard.pass(nothing, tick), Vec3(1, 0, 0));
    EXPECT_EQ(guard.refused(), 1U);
    EXPECT_EQ(guard.slewed(), 2U);
}

TEST(ForceGuard, ATickOfNoLengthKeepsTheForce)
{
    ForceGuard guard(without_ramps(), 3.3);
    const Vec3 force(1, 2, -2);
    EXPECT_EQ(guard.pass(force, 0), Vec3::Zero());
    EXPECT_EQ(guard.pass(Vec3::Zero(), 0), Vec3::Zero());
    EXPECT_EQ(guard.pass(force, tick), force);
    EXPECT_EQ(guard.pass(force, 0), force);
    EXPECT_EQ(guard.pass(Vec3::Zero(), 0), force);
}

TEST(ForceGuard, WithoutAStartingTimeBeginsWithTheWholeForce)
{
    ForceGuard guard(without_ramps(), 3.3);
    EXPECT_EQ(guard.ramp(), 1);
    EXPECT_EQ(guard.pass(Vec3(1, 0, 0), tick), Vec3(1, 0, 0));
    guard.restart();
    EXPECT_EQ(guard.ramp(), 1);
    EXPECT_EQ(guard.pass(Vec3(0, 2, 0), tick), Vec3(0, 2, 0));
    EXPECT_EQ(ForceGuard({.start_seconds = 0.25}, 3.3).ramp(), 0);
    guard.cross_over(); // the force before fades at once, for there is no time for it either
    EXPECT_EQ(guard.pass(Vec3(0, 0, 3), tick), Vec3(0, 0, 3));
}

TEST(ForceGuard, RampsUpAtTheStartAndDownWhenThePatchIsLost)
{
    ForceOptions options = without_ramps();
    options.start_seconds = 0.25;
    options.loss_seconds = 0.05;
    ForceGuard guard(options, 3.3);
    const Vec3 wanted(1, 0, 0);
    for (int i = 1; i <= 300; ++i)
        EXPECT_NEAR(guard.pass(wanted, tick).x(), std::min(1.0, i / 250.0), 1e-9);
    for (int i = 1; i <= 80; ++i)
        EXPECT_NEAR(guard.pass(wanted, tick, Patch::lost).x(), std::max(0.0, 1 - i / 50.0), 1e-9);
    EXPECT_EQ(guard.last(), Vec3::Zero());
    for (int i = 1; i <= 80; ++i)
        EXPECT_NEAR(guard.pass(wanted, tick).x(), std::min(1.0, i / 50.0), 1e-9);
    guard.restart();
    EXPECT_NEAR(guard.pass(wanted, tick).x(), 1 / 250.0, 1e-9);
}

TEST(ForceGuard, ARestartForgetsTheForceThatFades)
{
    ForceOptions options = without_ramps();
    options.loss_seconds = 0.05;
    ForceGuard guard(options, 3.3);
    EXPECT_EQ(guard.pass(Vec3(3, 0, 0), tick), Vec3(3, 0, 0));
    guard.cross_over();
    EXPECT_NEAR(guard.pass(Vec3::Zero(), tick).x(), 3 * (1 - 1 / 50.0), 1e-12);
    guard.restart();
    EXPECT_EQ(guard.pass(Vec3::Zero(), tick), Vec3::Zero());
}

TEST(ForceOptions, AreLimitedByTheDevice)
{
    const auto omni = find_device("omni");
    ASSERT_TRUE(omni);
    const ForceOptions options = limited({.stiffness = 1e6, .damping = 1e6}, *omni);
    EXPECT_EQ(options.stiffness, 700);
    EXPECT_EQ(options.damping, 5);
    EXPECT_EQ(limited({}, *omni).stiffness, 500);
    EXPECT_FALSE(find_device("hammer"));
    EXPECT_EQ(known_devices().size(), 6U);
}

} // namespace
} // namespace proxima::contact_force_test
