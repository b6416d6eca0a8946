// Self-tests of devices that misbehave, and of hands that do not follow them.
#include "haptics/known_device.h"
#include "haptics/self_test_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace proxima::self_test_faults_test {
namespace {

using testing::ChangedHand;
using testing::device;
using testing::quick_options;
using testing::run_self_test;
using testing::SelfTestSession;

TEST(SelfTest, PushesNothingThatDoesNotRest)
{
    // Heavier than its friction: it sinks, as an arm without a counterweight.
    ChangedHand hand(device(0.1, 0.5, 0.05, 2e-5, 0), {}, [](std::uint64_t, const Vec3& force) {
        return Vec3(force - Vec3(0, 0, 0.2));
    });
    SelfTestOptions options = quick_options();
    options.release_seconds = 1.5;
    const SelfTestSession session = run_self_test(hand, options);
    EXPECT_EQ(session.fault, SelfTestFault::none);
    EXPECT_FALSE(session.report.rested);
    EXPECT_EQ(session.pushed_ticks, 0U);
    EXPECT_FALSE(session.report.settings);
    EXPECT_NEAR(session.report.axes[0].encoder.step, 2e-5, 1e-8); // what the hand showed stays
}

TEST(SelfTest, WaitsForRestAgainWhenTheTipMoves)
{
    // Something knocks it by a millimetre, half a second after it seemed to rest.
    bool rests = false;
    std::uint64_t since = 0;
    double away = 0;
    ChangedHand hand(device(0.1, 0.5, 0.2, 2e-5, 1), [&](std::uint64_t, DeviceReading& reading) {
        since += rests ? 1U : 0U;
        if (since > 500) away = 1e-3;
        reading.state.pose.translation.x() += away;
    });
    const SelfTestSession session =
        run_self_test(hand, quick_options(), [&](std::uint64_t, SelfTest& test) {
            rests = rests || test.step() == SelfTestStep::rest;
        });
    EXPECT_EQ(session.fault, SelfTestFault::none);
    EXPECT_TRUE(session.report.rested);
    for (const AxisReport& axis : session.report.axes) {
        EXPECT_EQ(axis.noise_range, 0);
        EXPECT_TRUE(axis.motion.found);
    }
}

TEST(SelfTest, LeavesAloneWhatCoasts)
{
    // Without friction and damping nothing stops it after the first ramp.
    ChangedHand hand(device(0.1, 0, 0, 2e-5, 0));
    const SelfTestSession session = run_self_test(hand);
    EXPECT_EQ(session.fault, SelfTestFault::none);
    EXPECT_EQ(session.report.axes[0].ramps[0], SelfTestOutcome::complete);
    EXPECT_EQ(session.report.axes[0].ramps[1], SelfTestOutcome::no_rest);
}

TEST(SelfTest, SaysWhatTheLargestForceCannotMove)
{
    ChangedHand hand(device(0.1, 0.5, 1.2, 2e-5, 0)); // 0.99 N are allowed
    const SelfTestSession session = run_self_test(hand);
    EXPECT_EQ(session.fault, SelfTestFault::none);
    EXPECT_GT(session.largest_force, 0.98);
    for (const AxisReport& axis : session.report.axes) {
        EXPECT_EQ(axis.ramps[0], SelfTestOutcome::unmoved);
        EXPECT_EQ(axis.pushes[0], SelfTestOutcome::too_weak);
        EXPECT_FALSE(axis.static_friction);
        EXPECT_FALSE(axis.motion.found);
    }
    EXPECT_FALSE(session.report.settings);
}

TEST(SelfTest, NoticesAHandThatHoldsOn)
{
    // A spring holds the tip in the middle, as fingers do.
    Vec3 tip = Vec3::Zero();
    Vec3 rest = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    bool rests = false;
    ChangedHand hand(
        device(0.1, 0.5, 0, 2e-5, 1),
        [&](std::uint64_t, DeviceReading& reading) {
            tip = reading.state.pose.translation;
            velocity = reading.state.velocity;
        },
        [&](std::uint64_t, const Vec3& force) {
            if (force.norm() > 0 && !rests) {
                rests = true;
                rest = tip;
            }
            return rests ? Vec3(force + 120 * (rest - tip)) : force;
        });
    const SelfTestSession session = run_self_test(hand);
    EXPECT_TRUE(session.report.held);
}

TEST(SelfTest, StopsWhatRunsAway)
{
    // Something multiplies forces by twenty.
    ChangedHand hand(device(0.05, 0.1, 0, 2e-5, 0), {},
                     [](std::uint64_t, const Vec3& force) { return Vec3(20 * force); });
    const SelfTestSession session = run_self_test(hand);
    EXPECT_EQ(session.fault, SelfTestFault::none);
    std::ptrdiff_t stopped = 0;
    for (const AxisReport& axis : session.report.axes)
        stopped += std::ranges::count(axis.pushes, SelfTestOutcome::too_far);
    EXPECT_GT(stopped, 0);
}

TEST(SelfTest, EndsWithZeroForceAtTheFirstFault)
{
    const HandModel model = device(0.1, 0.5, 0.2, 2e-5, 1);
    struct Case {
        SelfTestFault fault;
        void (*change)(DeviceReading& reading);
    };
    const std::vector<Case> cases = {
        {SelfTestFault::not_finite,
         [](DeviceReading& reading) {
             reading.state.pose.translation.y() = std::numeric_limits<double>::quiet_NaN();
         }},
        {SelfTestFault::not_finite,
         [](DeviceReading& reading) {
             reading.state.pose.translation.x() = std::numeric_limits<double>::infinity();
         }},
        {SelfTestFault::jumped,
         [](DeviceReading& reading) { reading.state.pose.translation.x() += 0.5; }},
        {SelfTestFault::gone,
         [](DeviceReading& reading) { reading.state.condition = InputCondition::gone; }},
        {SelfTestFault::left,
         [](DeviceReading& reading) { reading.state.condition = InputCondition::released; }},
        {SelfTestFault::refused,
         [](DeviceReading& reading) { reading.state.condition = InputCondition::unsure; }},
        {SelfTestFault::silent,
         [](DeviceReading& reading) {
             reading = {{}, 5};
         }},
    };
    for (const Case& fault : cases) {
        // While the hand moves it, and while the motors push.
        for (const std::uint64_t at : {3000U, 12000U, 22000U}) {
            SCOPED_TRACE(::testing::Message() << static_cast<int>(fault.fault) << " at " << at);
            double after = 0;
            ChangedHand hand(
                model,
                [&](std::uint64_t tick, DeviceReading& reading) {
                    if (tick >= at) fault.change(reading);
                },
                [&](std::uint64_t tick, const Vec3& force) {
                    if (tick >= at + (fault.fault == SelfTestFault::silent ? 21 : 0))
                        after = std::max(after, force.norm());
                    return force;
                });
            const SelfTestSession session = run_self_test(hand);
            EXPECT_EQ(session.fault, fault.fault);
            EXPECT_TRUE(session.finished);
            EXPECT_EQ(after, 0);
            EXPECT_LE(session.ticks, at + 1100);
            // What the test did not come to is not called complete.
            for (const AxisReport& axis : session.report.axes)
                EXPECT_EQ(axis.pushes[1], SelfTestOutcome::not_done);
        }
    }
    // Nothing ever comes.
    ChangedHand dumb(model, [](std::uint64_t, DeviceReading& reading) { reading = {{}, 0}; });
    const SelfTestSession session = run_self_test(dumb);
    EXPECT_EQ(session.fault, SelfTestFault::no_sample);
    EXPECT_NEAR(static_cast<double>(session.ticks), 1000, 20);
}

TEST(SelfTest, IsCancelledAtOnce)
{
    for (const std::uint64_t at : {10U, 3000U, 12000U, 22000U}) {
        ChangedHand hand(device(0.1, 0.5, 0.2, 2e-5, 1));
        const SelfTestSession session =
            run_self_test(hand, quick_options(), [&](std::uint64_t tick, SelfTest& test) {
                if (tick == at) test.cancel();
            });
        EXPECT_EQ(session.fault, SelfTestFault::cancelled);
        EXPECT_LE(session.ticks, at + 12);
    }
}

TEST(SelfTest, WaitsForThePersonUntilConfirmed)
{
    SelfTestOptions options = quick_options();
    options.prepare_seconds = 1000;
    ChangedHand hand(device(0.1, 0.5, 0.2, 2e-5, 1));
    int confirmed = 0;
    const SelfTestSession session =
        run_self_test(hand, options, [&](std::uint64_t tick, SelfTest& test) {
            if (!test.prepares() || tick % 500 != 499) return;
            ++confirmed;
            test.confirm();
        });
    EXPECT_EQ(confirmed, 3); // slow, fast, release
    EXPECT_TRUE(session.report.settings);
}

TEST(SelfTest, RefusesOptionsOutOfRange)
{
    const DeviceInfo info;
    const auto name_of = [&](const SelfTestOptions& options) {
        const auto test = SelfTest::make(info, options);
        return test ? std::string() : test.error().where;
    };
    EXPECT_EQ(name_of({}), "");
    EXPECT_EQ(name_of({.tick_seconds = 0}), "tick_seconds");
    EXPECT_EQ(name_of({.ramp_rate = 0}), "ramp_rate");
    EXPECT_EQ(name_of({.force_share = 1.1}), "force_share");
    EXPECT_EQ(name_of({.slow_seconds = -1}), "slow_seconds");
    EXPECT_EQ(name_of({.most_speed = std::numeric_limits<double>::infinity()}), "most_speed");
}

} // namespace
} // namespace proxima::self_test_faults_test
