// Known devices, pushed to and fro. Between ticks they are simulated in parts, so that friction stops
// them when it should.
#include "haptics/device/motion_fit.h"
#include "haptics/known_device.h"
#include "lab/simulated_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace proxima::motion_fit_test {
namespace {

using testing::device;
using testing::expect_numbers;

constexpr double tick = 1e-3;
constexpr int parts = 20;
constexpr std::size_t lead = 200;

/// Pushes a device along x, once in each direction.
class PushedDevice {
public:
    /// A constant force of `weight`; each push begins with a speed of `drift`.
    explicit PushedDevice(const HandModel& model, double weight = 0, double drift = 0)
        : delay_(static_cast<std::size_t>(model.delay_ticks)), step_(model.encoder_step),
          weight_(weight), drift_(drift), hand_(in_parts(model), Vec3(3.3e-4, 0, 0))
    {}

    /// A part of the samples can be missing.
    MotionFit fit(double force, double drop = 0, std::mt19937_64* random = nullptr)
    {
        const std::vector<PushSample> there = push(force, drop, random);
        const std::vector<PushSample> back = push(-force, drop, random);
        const std::vector<Push> pushes = {{there, lead}, {back, lead}};
        return fit_motion(pushes, {.resolution = step_});
    }

private:
    static HandModel in_parts(HandModel model)
    {
        model.tick_seconds = tick / parts;
        model.delay_ticks = 0;
        return model;
    }

    std::vector<PushSample> push(double force, double drop, std::mt19937_64* random)
    {
        std::vector<PushSample> samples;
        std::uniform_real_distribution<double> part(0, 1);
        const auto pass = [&](double f) {
            PushSample now{.seconds = tick * static_cast<double>(forces_.size()),
                           .position = hand_.state().pose.translation.x(),
                           .force = f};
            now.fresh = random == nullptr || part(*random) >= drop;
            if (!now.fresh && !samples.empty()) now.position = samples.back().position;
            samples.push_back(now);
            forces_.push_back(f);
            const double felt =
                forces_.size() > delay_ ? forces_[forces_.size() - 1 - delay_] : 0.0;
            for (int i = 0; i < parts; ++i) hand_.step(Vec3(felt + weight_, 0, 0), Vec3::Zero());
            return hand_.position().x();
        };
        for (int i = 0; i < 3000; ++i) pass(0); // at rest again
        samples.clear();
        if (drift_ != 0) hand_.set_motion(hand_.position(), Vec3(drift_, 0, 0));
        double begun = 0;
        for (std::size_t i = 0; i < lead; ++i) begun = pass(0);
        int first = 0;
        double x = begun;
        while (first < 20 || (first < 200 && std::abs(x - begun) < 2e-3)) {
            x = pass(force);
            ++first;
        }
        for (int i = 0; i < 2 * first; ++i) pass(-force);
        for (int i = 0; i < first; ++i) pass(force);
        for (int i = 0; i < 400; ++i) pass(0);
        return samples;
    }

    std::size_t delay_;
    double step_;
    double weight_;
    double drift_;
    SimulatedHand hand_;
    std::vector<double> forces_;
};

/// A device that nobody holds.
HandModel free_device(double mass, double damping, double friction, double step, int delay)
{
    HandModel model = device(mass, damping, friction, step, delay);
    model.hand_stiffness = model.hand_damping = 0;
    return model;
}

TEST(MotionFit, FindsTheNumbersOfADevice)
{
    constexpr std::array steps = {0.0, 1e-5, 6e-5};
    constexpr std::array delays = {0, 1, 3, 5};
    for (std::size_t i = 0; i < 8 * steps.size() * delays.size(); ++i) {
        const double friction = i / 4 % 2 == 0 ? 0.0 : 0.2;
        const HandModel model =
            free_device(i % 2 == 0 ? 0.05 : 0.2, i / 2 % 2 == 0 ? 0.0 : 0.5, friction,
                        steps[i / 8 % steps.size()], delays[i / 8 / steps.size()]);
        SCOPED_TRACE(::testing::Message()
                     << model.mass << ' ' << model.device_damping << ' ' << friction << ' '
                     << model.encoder_step << ' ' << model.delay_ticks);
        const MotionFit fit = PushedDevice(model).fit(friction > 0 ? 0.6 : 0.3);
        expect_numbers(fit, model);
        EXPECT_FALSE(fit.stiffness.is_certain() && fit.stiffness.value > 5) << fit.stiffness.value;
    }
}

TEST(MotionFit, FindsTheNumbersOfRandomDevices)
{
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> part(0, 1);
    for (int i = 0; i < 60; ++i) {
        const double friction = part(random) < 0.3 ? 0 : 0.4 * part(random);
        const HandModel model = free_device(
            0.04 * std::pow(10, part(random)), 0.02 * std::pow(50, part(random)), friction,
            1e-6 * std::pow(80, part(random)), static_cast<int>(6 * part(random)));
        SCOPED_TRACE(::testing::Message() << "device " << i << " of seed 11: " << model.mass << ' '
                                          << model.device_damping << ' ' << friction << ' '
                                          << model.encoder_step << ' ' << model.delay_ticks);
        expect_numbers(PushedDevice(model).fit(std::max(0.3, 2.5 * friction)), model);
    }
}

TEST(MotionFit, TakesWeightAndMissingSamples)
{
    std::mt19937_64 random(12);
    const HandModel model = free_device(0.1, 0.3, 0.2, 3e-5, 2);
    const MotionFit heavy = PushedDevice(model, 0.1).fit(0.6);
    expect_numbers(heavy, model);
    EXPECT_NEAR(heavy.weight, 0.1, 0.01);
    expect_numbers(PushedDevice(model).fit(0.6, 0.3, &random), model);
}

TEST(MotionFit, TakesADeviceThatCoasts)
{
    // The device coasts as slowly as what counts as rest: 0.5 mm in the time of a push.
    const HandModel model = free_device(0.3, 0.05, 0, 1e-5, 1);
    const MotionFit fit = PushedDevice(model, 0, 6e-4).fit(0.3);
    ASSERT_TRUE(fit.found);
    EXPECT_EQ(fit.delay, 1);
    EXPECT_NEAR(fit.mass.value, 0.3, 0.003);
    EXPECT_NEAR(fit.damping.value, 0.05, 0.01);
    EXPECT_LT(fit.friction.value, 0.002);
    EXPECT_LT(fit.residual, 1e-5);
}

TEST(MotionFit, SaysWhatHoldsTheDevice)
{
    HandModel model = free_device(0.1, 0.5, 0, 2e-5, 1);
    model.hand_stiffness = 150;
    model.hand_damping = 3;
    const MotionFit fit = PushedDevice(model).fit(0.6);
    ASSERT_TRUE(fit.found);
    EXPECT_TRUE(fit.stiffness.is_certain());
    EXPECT_NEAR(fit.stiffness.value, 150, 8);
    EXPECT_NEAR(fit.damping.value, 3.5, 0.3); // of both
}

TEST(MotionFit, SaysNothingOfADeviceThatHardlyMoves)
{
    EXPECT_FALSE(fit_motion({}, {}).found);
    EXPECT_FALSE(PushedDevice(free_device(0.1, 0.5, 1, 2e-5, 1)).fit(0.6).found);
}

TEST(MotionFit, FindsLongDelays)
{
    for (const int delay : {25, 40, 64}) {
        const HandModel model = free_device(0.3, 0.5, 0.3, 5e-5, delay);
        SCOPED_TRACE(delay);
        expect_numbers(PushedDevice(model).fit(0.9), model);
    }
}

TEST(MotionFit, SaysThatADelayMayBeLongerThanItCanTell)
{
    for (const int delay : {80, 81, 100, 150}) {
        const MotionFit fit = PushedDevice(free_device(0.3, 0.5, 0.3, 5e-5, delay)).fit(0.9);
        SCOPED_TRACE(delay);
        EXPECT_FALSE(fit.found);
        EXPECT_TRUE(fit.is_later);
        EXPECT_GE(fit.least_delay, 60);
        EXPECT_LE(fit.least_delay, 80);
    }
}

} // namespace
} // namespace proxima::motion_fit_test
