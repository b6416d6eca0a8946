// Self-tests of simulated devices whose numbers are known.
#include "haptics/known_device.h"
#include "haptics/self_test_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace proxima::self_test_test {
namespace {

using testing::ChangedHand;
using testing::device;
using testing::expect_numbers;
using testing::quick_options;
using testing::run_self_test;
using testing::SelfTestSession;

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

TEST(SelfTest, SuggestsNothingWhereTheDelayMayBeLongerThanItCanTell)
{
    // Along z forces come 35 ticks later still.
    std::vector<double> late(35, 0);
    ChangedHand hand(
        device(0.8, 0.5, 0.3, 5e-5, 50), {}, [&](std::uint64_t tick, const Vec3& force) {
            return Vec3(force.x(), force.y(), std::exchange(late[tick % late.size()], force.z()));
        });
    const SelfTestSession session = run_self_test(hand);
    EXPECT_EQ(session.report.axes[0].motion.delay, 50);
    EXPECT_TRUE(session.report.axes[1].motion.found);
    EXPECT_FALSE(session.report.axes[2].motion.found);
    EXPECT_TRUE(session.report.axes[2].motion.is_later);
    EXPECT_FALSE(session.report.settings);
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

} // namespace
} // namespace proxima::self_test_test
