// Self-tests of simulated devices whose numbers are known, and of devices that misbehave.
#include "haptics/known_device.h"
#include "haptics/self_test_session.h"
#include "haptics/theory_wall.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace proxima {
namespace {

using testing::ChangedHand;
using testing::device;
using testing::expect_numbers;
using testing::quick_options;
using testing::run_self_test;
using testing::SelfTestSession;
using testing::theory_swing;

/// The largest error of a breakaway force, N. It is seen when the growing force has moved the mass by a
/// step at most, and half a step is taken off: that leaves (6 m D r^2)^(1/3) at most. A device without
/// friction coasts by some hundredths of a millimetre before the force, which counts as a step does.
double breakaway_error(const HandModel& model)
{
    const double rate = SelfTestOptions{}.ramp_rate;
    const double coasting = model.coulomb_friction > 0 ? 0 : 2e-5;
    return std::cbrt(6 * model.mass * (model.encoder_step + coasting) * rate * rate) + 0.001;
}

/// Every number along every axis is that of the device.
void expect_numbers(const SelfTestSession& session, const HandModel& model)
{
    EXPECT_EQ(session.fault, SelfTestFault::none);
    ASSERT_TRUE(session.report.rested);
    EXPECT_FALSE(session.report.held);
    EXPECT_EQ(session.report.delay, model.delay_ticks);
    for (const AxisReport& axis : session.report.axes) {
        if (model.encoder_step > 0) {
            EXPECT_EQ(axis.encoder.kind, StepKind::grid);
            EXPECT_NEAR(axis.encoder.step, model.encoder_step, 1e-3 * model.encoder_step);
        } else {
            EXPECT_EQ(axis.encoder.kind, StepKind::invisible);
        }
        if (model.coulomb_friction > 0) {
            EXPECT_EQ(axis.noise_range, 0);
        }
        ASSERT_TRUE(axis.static_friction);
        EXPECT_NEAR(*axis.static_friction, model.coulomb_friction, breakaway_error(model));
        EXPECT_LE(breakaway_error(model), std::max(0.1 * model.coulomb_friction, 0.0105));
        EXPECT_NEAR(axis.weight, 0, breakaway_error(model));
        const MotionFit& motion = axis.motion;
        expect_numbers(motion, model);
        EXPECT_EQ(motion.least_delay, model.delay_ticks);
        EXPECT_EQ(motion.most_delay, model.delay_ticks);
    }
}

TEST(SelfTest, FindsTheNumbersOfSimulatedDevices)
{
    for (int i = 0; i < 48; ++i) {
        const bool light = i % 2 == 0;
        const HandModel model =
            device(light ? 0.05 : 0.2, light ? 0.2 : 0.8, i / 2 % 2 == 0 ? 0.0 : 0.2,
                   i / 4 % 2 == 0 ? 0.0 : 5e-5, i / 8);
        SCOPED_TRACE(::testing::Message()
                     << model.mass << ' ' << model.device_damping << ' ' << model.coulomb_friction
                     << ' ' << model.encoder_step << ' ' << model.delay_ticks);
        ChangedHand hand(model);
        expect_numbers(run_self_test(hand), model);
    }
}

TEST(SelfTest, FindsTheNumbersOfRandomDevices)
{
    std::mt19937_64 random(21);
    std::uniform_real_distribution<double> part(0, 1);
    double lateness = 0;
    int ramps = 0;
    for (int i = 0; i < 40; ++i) {
        const double mass = 0.04 * std::pow(8, part(random));
        const HandModel model =
            device(mass, mass * (1 + 5 * part(random)), part(random) < 0.3 ? 0 : 0.4 * part(random),
                   1e-6 * std::pow(60, part(random)), static_cast<int>(6 * part(random)));
        SCOPED_TRACE(::testing::Message() << "device " << i << " of seed 21: " << model.mass << ' '
                                          << model.device_damping << ' ' << model.coulomb_friction
                                          << ' ' << model.encoder_step << ' ' << model.delay_ticks);
        ChangedHand hand(model);
        const SelfTestSession session = run_self_test(hand);
        expect_numbers(session, model);
        if (!(model.coulomb_friction > 0)) continue;
        for (const AxisReport& axis : session.report.axes) {
            lateness += (axis.static_friction.value_or(1) - model.coulomb_friction) /
                        (breakaway_error(model) - 0.001);
            ++ramps;
        }
    }
    // In parts of (6 m D r^2)^(1/3): what is seen after a part u of a step, even between 0 and 1, is late
    // by u^(1/3), 3/4 in the mean, of which (1/2)^(1/3) is taken off. One by one they differ by 0.2.
    ASSERT_GT(ramps, 50);
    EXPECT_NEAR(lateness / ramps, 0.75 - std::cbrt(0.5), 0.1);
}

TEST(SelfTest, CountsSamplesThatAreNotNew)
{
    const HandModel model = device(0.1, 0.5, 0.1, 2e-5, 1);
    // Every second tick has the sample of the tick before: 500 Hz, and it says so.
    DeviceReading kept;
    ChangedHand slow(model, [&](std::uint64_t tick, DeviceReading& reading) {
        if (tick % 2 == 1) reading = kept;
        kept = reading;
    });
    const SelfTestSession numbered = run_self_test(slow);
    EXPECT_NEAR(numbered.report.timing.sample_rate, 500, 1);
    EXPECT_NEAR(numbered.report.timing.mean_interval, 2e-3, 1e-5);
    ASSERT_TRUE(numbered.report.timing.repeated);
    EXPECT_EQ(*numbered.report.timing.repeated, 0);
    EXPECT_TRUE(numbered.report.axes[0].motion.found);
    EXPECT_NEAR(numbered.report.axes[0].motion.mass.value, 0.1, 0.003);

    // The device repeats its samples again, and the driver counts each of them as new.
    ChangedHand hidden(model, [&](std::uint64_t tick, DeviceReading& reading) {
        const std::uint64_t number = reading.sample;
        if (tick % 2 == 1) reading = kept;
        reading.sample = number;
        kept = reading;
    });
    const SelfTestSession told = run_self_test(hidden);
    EXPECT_NEAR(told.report.timing.sample_rate, 1000, 1);
    ASSERT_TRUE(told.report.timing.repeated);
    EXPECT_NEAR(*told.report.timing.repeated, 0.5, 0.01);

    ChangedHand good(model);
    const SelfTestSession all = run_self_test(good);
    EXPECT_NEAR(all.report.timing.sample_rate, 1000, 1);
    EXPECT_LT(*all.report.timing.repeated, 0.01);
    EXPECT_EQ(all.report.timing.samples, all.report.timing.ticks);
}

TEST(SelfTest, MeasuresJitter)
{
    // Readings come up to 0.4 ms late, evenly: intervals deviate by 0.4 / sqrt(6) ms, and by the 7 ms
    // that one of 7000 is longer.
    std::mt19937_64 random(22);
    std::uniform_real_distribution<double> late(0, 4e-4);
    SelfTestHand hand("hand", device(0.1, 0.5, 0.1, 2e-5, 0), *find_device("omni"));
    auto test = SelfTest::make(hand.info(), quick_options());
    ASSERT_TRUE(test);
    hand.follow(*test);
    for (std::uint64_t tick = 0; !test->has_ended(); ++tick) {
        const double seconds = 1e-3 * static_cast<double>(tick);
        // Once, 7 ms are lost.
        const double lost = seconds > 1 ? 7e-3 : 0;
        hand.write(test->tick(hand.read(), seconds, seconds + lost + late(random)));
    }
    const SampleTiming timing = report_of(*test, hand.info().limits).timing;
    EXPECT_NEAR(timing.sample_rate, 1000, 2);
    const double of_loss = 7e-3 * 7e-3 / 7000;
    EXPECT_NEAR(timing.interval_deviation, std::sqrt(4e-4 * 4e-4 / 6 + of_loss), 5e-6);
    EXPECT_NEAR(timing.longest_interval, 8e-3, 4e-4);
    // The difference of two even ones exceeds 0.4 (1 - sqrt(0.02)) ms in a hundredth of all cases.
    EXPECT_NEAR(timing.interval_p99, 1e-3 + 4e-4 * (1 - std::sqrt(0.02)), 2e-5);
}

TEST(SelfTest, MeasuresNoise)
{
    std::mt19937_64 random(23);
    std::normal_distribution<double> noise(0, 4e-6);
    ChangedHand hand(device(0.1, 0.5, 0.2, 0, 1), [&](std::uint64_t, DeviceReading& reading) {
        for (int i = 0; i < 3; ++i) reading.state.pose.translation[i] += noise(random);
    });
    const SelfTestSession session = run_self_test(hand);
    for (const AxisReport& axis : session.report.axes) {
        EXPECT_NEAR(axis.noise, 4e-6, 4e-7); // four standard errors of a thousand samples
        EXPECT_GT(axis.noise_range, 5 * 4e-6);
        EXPECT_LT(axis.noise_range, 10 * 4e-6);
        ASSERT_TRUE(axis.motion.found);
        EXPECT_EQ(axis.motion.delay, 1);
        EXPECT_NEAR(axis.motion.mass.value, 0.1, 0.01);
        ASSERT_TRUE(axis.static_friction);
        EXPECT_NEAR(*axis.static_friction, 0.2, 0.01);
    }
}

TEST(SelfTest, TellsFrictionAtRestFromFrictionInMotion)
{
    // What rests takes 0.3 N to move; then 0.2 N hold it back.
    Vec3 before = Vec3::Zero();
    int rested = 0;
    ChangedHand hand(
        device(0.1, 0.5, 0.2, 1e-5, 1),
        [&](std::uint64_t, DeviceReading& reading) {
            const Vec3& position = reading.state.pose.translation;
            rested = position == before ? rested + 1 : 0;
            before = position;
        },
        [&](std::uint64_t, const Vec3& force) {
            return rested > 100 && force.norm() < 0.3 ? Vec3(Vec3::Zero()) : force;
        });
    const SelfTestSession session = run_self_test(hand);
    for (const AxisReport& axis : session.report.axes) {
        ASSERT_TRUE(axis.static_friction);
        EXPECT_NEAR(*axis.static_friction, 0.3, 0.01);
        ASSERT_TRUE(axis.motion.found);
        EXPECT_NEAR(axis.motion.friction.value, 0.2, 0.01);
        EXPECT_NEAR(axis.motion.mass.value, 0.1, 0.005);
        EXPECT_EQ(axis.motion.delay, 1);
    }
}

TEST(SelfTest, TakesAnArmWithEncodersInItsJoints)
{
    // A waist that turns, a shoulder that lifts, and a reach, 0.2 m behind the middle: the encoders
    // step by 0.05 to 0.06 mm at the tip, across the axes.
    const Vec3 base(0, -0.2, -0.05);
    const auto in_steps = [](double value, double step) { return std::round(value / step) * step; };
    ChangedHand hand(device(0.15, 0.4, 0.25, 0, 2), [&](std::uint64_t, DeviceReading& reading) {
        Vec3& position = reading.state.pose.translation;
        const Vec3 arm = position - base;
        const double waist = in_steps(std::atan2(arm.x(), arm.y()), 2.6e-4);
        const double shoulder = in_steps(std::atan2(arm.z(), std::hypot(arm.x(), arm.y())), 2.7e-4);
        const double reach = in_steps(arm.norm(), 5.5e-5);
        position = base + reach * Vec3(std::cos(shoulder) * std::sin(waist),
                                       std::cos(shoulder) * std::cos(waist), std::sin(shoulder));
    });
    const SelfTestSession session = run_self_test(hand);
    EXPECT_EQ(session.report.delay, 2);
    for (const AxisReport& axis : session.report.axes) {
        EXPECT_EQ(axis.encoder.kind, StepKind::uneven);
        EXPECT_GT(axis.encoder.step, 4.5e-5);
        EXPECT_LT(axis.encoder.step, 7e-5);
        ASSERT_TRUE(axis.motion.found);
        EXPECT_EQ(axis.motion.delay, 2);
        EXPECT_NEAR(axis.motion.mass.value, 0.15, 0.0075);
        EXPECT_NEAR(axis.motion.friction.value, 0.25, 0.0125);
        ASSERT_TRUE(axis.static_friction);
        EXPECT_NEAR(*axis.static_friction, 0.25, 0.015);
    }
}

TEST(SelfTest, TellsWeightFromFriction)
{
    const HandModel model = device(0.1, 0.5, 0.2, 2e-5, 1);
    const Vec3 weight(0, 0, -0.08);
    ChangedHand hand(model, {},
                     [&](std::uint64_t, const Vec3& force) { return Vec3(force + weight); });
    const SelfTestSession session = run_self_test(hand);
    const AxisReport& vertical = session.report.axes[2];
    ASSERT_TRUE(vertical.static_friction);
    EXPECT_NEAR(*vertical.breakaway[0], 0.28, 0.01);
    EXPECT_NEAR(*vertical.breakaway[1], 0.12, 0.01);
    EXPECT_NEAR(*vertical.static_friction, 0.2, 0.01);
    EXPECT_NEAR(vertical.weight, -0.08, 0.01);
    EXPECT_NEAR(vertical.motion.weight, -0.08, 0.01);
    EXPECT_NEAR(vertical.motion.mass.value, 0.1, 0.003);
}

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

TEST(SelfTest, RepeatsWhatAGapHasSpoilt)
{
    const HandModel model = device(0.1, 0.5, 0.2, 2e-5, 2);
    // No new sample for 60 ms, in every second.
    ChangedHand hand(model, [](std::uint64_t tick, DeviceReading& reading) {
        if (tick > 9000 && tick % 4000 < 60) reading.sample = 7;
    });
    const SelfTestSession session = run_self_test(hand);
    expect_numbers(session, model);
    // And not for ever.
    ChangedHand worse(model, [](std::uint64_t tick, DeviceReading& reading) {
        if (tick > 9000 && tick % 1000 < 60) reading.sample = 7;
    });
    const SelfTestSession given_up = run_self_test(worse);
    EXPECT_EQ(given_up.fault, SelfTestFault::silent);
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

MotionFit motion(double mass, const Fitted& damping, const Fitted& friction)
{
    return {.mass = {mass, 0}, .damping = damping, .friction = friction, .found = true};
}

TEST(SuggestedSettings, AreStableAndNearTheLimit)
{
    // Walls in theory, on devices that nobody holds: what is suggested calms down, and a third above
    // the limit by the delay oscillates.
    const DeviceLimits limits = *find_device("omega");
    for (const auto& [damping, delay] : {std::pair(0.2, 0), std::pair(0.2, 1), std::pair(0.2, 3),
                                         std::pair(1.0, 0), std::pair(1.0, 1), std::pair(1.0, 3)}) {
        HandModel model = device(0.15, damping, 0, 0, delay);
        model.hand_stiffness = model.hand_damping = 0;
        model.velocity = VelocityEstimate::exact;
        const SuggestedSettings settings =
            suggest_settings(limits, 1e-3, delay, motion(0.15, {damping, 0}, {}), 0);
        SCOPED_TRACE(::testing::Message() << damping << ' ' << delay << ": " << settings.stiffness
                                          << ' ' << settings.damping);
        EXPECT_GT(settings.stiffness, 0);
        EXPECT_LT(theory_swing(model, {settings.stiffness, settings.damping}, 20000), 1e-4);
        EXPECT_GT(theory_swing(model, {1.3 * settings.by_delay, settings.damping}, 20000), 1e-2);
        EXPECT_NEAR(settings.by_delay, (damping + settings.damping) / (1e-3 * (0.5 + delay)),
                    1e-9 * settings.by_delay);
    }
}

TEST(SuggestedSettings, FollowTheLimits)
{
    const DeviceLimits omni = *find_device("omni"); // 700 N/m, 5 N s/m
    // 2 f / D = 400 N/m, and its damping is limited by f T / D = 0.2 N s/m.
    const SuggestedSettings coarse =
        suggest_settings(omni, 1e-3, 0, motion(0.1, {0.5, 0.01}, {0.01, 1e-4}), 5e-5);
    EXPECT_NEAR(*coarse.by_encoder, 400, 1e-9);
    EXPECT_NEAR(*coarse.passive, 1000, 1e-9);
    EXPECT_NEAR(coarse.damping, 0.2, 1e-9);
    EXPECT_EQ(coarse.limit, StiffnessLimit::encoder);
    EXPECT_NEAR(coarse.stiffness, 320, 1e-9);
    // Nothing of the device's own is known: its damping counts as none.
    const SuggestedSettings unknown =
        suggest_settings(omni, 1e-3, 2, motion(0.1, {0.1, 0.1}, {}), 0);
    EXPECT_FALSE(unknown.passive);
    EXPECT_FALSE(unknown.by_encoder);
    EXPECT_NEAR(unknown.by_delay, unknown.damping / 2.5e-3, 1e-9);
    EXPECT_EQ(unknown.limit, StiffnessLimit::device); // with enough of the surface's damping
    EXPECT_EQ(unknown.stiffness, 700);
    EXPECT_NEAR(unknown.damping, 2.2, 1e-9); // 700 / 0.8 * 2.5 ms = 2.19
    // A delay that no damping makes up for.
    const SuggestedSettings late = suggest_settings(omni, 1e-3, 20, motion(10, {0.5, 0.01}, {}), 0);
    EXPECT_EQ(late.limit, StiffnessLimit::delay);
    EXPECT_EQ(late.damping, 5);
    EXPECT_NEAR(late.by_delay, 5.5 / 20.5e-3, 1e-9);
    EXPECT_NEAR(late.stiffness, 210, 1e-9); // 0.8 * 268.3
    // A light device, which late damping would drive.
    const SuggestedSettings light = suggest_settings(omni, 1e-3, 2, motion(0.01, {}, {}), 0);
    EXPECT_NEAR(light.damping, 1.2, 1e-9); // 0.3 * 0.01 / 2.5 ms
}

} // namespace
} // namespace proxima
