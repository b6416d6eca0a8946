#include "haptics/device/encoder_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace proxima::encoder_step_test {
namespace {

/// A slow motion to and fro, as an encoder of that step reports it; 0 for none.
std::vector<double> slow_motion(double step, double offset, int samples = 5000)
{
    std::vector<double> positions;
    for (int i = 0; i < samples; ++i) {
        const double t = 1e-3 * i;
        const double x = offset + 0.01 * std::sin(1.9 * t) + 0.003 * std::sin(7.1 * t);
        positions.push_back(step > 0 ? std::round(x / step) * step : x);
    }
    return positions;
}

TEST(EncoderStep, IsExactOnAGrid)
{
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> part(0, 1);
    for (int i = 0; i < 200; ++i) {
        const double step = 1e-6 * std::pow(100, part(random));
        const EncoderStep found = estimate_encoder_step(slow_motion(step, 0.1 * part(random)));
        EXPECT_EQ(found.kind, StepKind::grid) << step;
        EXPECT_NEAR(found.step, step, 1e-9 * step);
    }
}

TEST(EncoderStep, IsRightToAPerCentBeneathNoiseAndGlitches)
{
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> part(0, 1);
    std::normal_distribution<double> normal(0, 1);
    for (int i = 0; i < 100; ++i) {
        // So slow that positions repeat; noise that is the same while they do.
        const double step = 5e-5 * std::pow(2, part(random));
        std::vector<double> exact = slow_motion(step, 0.1 * part(random));
        std::vector<double> positions = exact;
        double noise = 0;
        for (std::size_t k = 0; k < positions.size(); ++k) {
            if (k == 0 || exact[k] != exact[k - 1]) noise = 0.05 * step * normal(random);
            positions[k] += noise;
        }
        const EncoderStep noisy = estimate_encoder_step(positions);
        EXPECT_EQ(noisy.kind, StepKind::grid) << step;
        EXPECT_NEAR(noisy.step, step, 0.01 * step);
        // One change in two hundred is anything.
        positions = exact;
        for (double& position : positions)
            if (part(random) < 0.001) position += step * part(random);
        const EncoderStep glitched = estimate_encoder_step(positions);
        EXPECT_EQ(glitched.kind, StepKind::grid) << step;
        EXPECT_NEAR(glitched.step, step, 0.01 * step);
    }
}

TEST(EncoderStep, IsFoundWhereNoChangeIsASingleStep)
{
    std::vector<double> positions{0};
    constexpr std::array<double, 4> changes = {2, -3, 5, -4};
    for (std::size_t i = 0; i < 400; ++i)
        positions.push_back(positions.back() + 3e-5 * changes[i % changes.size()]);
    const EncoderStep found = estimate_encoder_step(positions);
    EXPECT_EQ(found.kind, StepKind::grid);
    EXPECT_NEAR(found.step, 3e-5, 1e-12);
}

TEST(EncoderStep, IsNearTheCoarsestOfAnArmWithEncodersInItsJoints)
{
    // Two links of 0.13 m, as a desktop arm has them; the tip's x.
    constexpr double joint_step = 4e-4; // rad
    constexpr double link = 0.13;
    std::vector<double> positions;
    for (int i = 0; i < 8000; ++i) {
        const double t = 1e-3 * i;
        const auto joint = [&](double at, double hertz) {
            return std::round((at + 0.06 * std::sin(6.28 * hertz * t)) / joint_step) * joint_step;
        };
        const double first = joint(0.6, 0.11);
        positions.push_back(link * (std::cos(first) + std::cos(first + joint(1.1, 0.17))));
    }
    const EncoderStep found = estimate_encoder_step(positions);
    EXPECT_EQ(found.kind, StepKind::uneven);
    // By the columns of the Jacobian: the first joint moves x by the tip's height, the second by the
    // second link's. The first is the coarser one, up to this where the tip is highest.
    const double second = link * std::sin(1.7) * joint_step;
    const double first = link * (std::sin(0.66) + 1) * joint_step;
    EXPECT_GT(found.step, 1.2 * second);
    EXPECT_LT(found.step, first);
}

TEST(EncoderStep, IsInvisibleInPositionsWithoutSteps)
{
    const EncoderStep found = estimate_encoder_step(slow_motion(0, 0));
    EXPECT_EQ(found.kind, StepKind::invisible);
    EXPECT_EQ(found.step, 0);
    EXPECT_GT(found.least_change, 0);
}

TEST(EncoderStep, IsUnknownWithoutMotion)
{
    EXPECT_EQ(estimate_encoder_step({}).kind, StepKind::unknown);
    EXPECT_EQ(estimate_encoder_step(slow_motion(0.005, 0)).kind, StepKind::unknown);
    EXPECT_EQ(estimate_encoder_step(std::vector<double>(5000, 0.1)).kind, StepKind::unknown);
}

TEST(EncoderStep, RoundingIsNoMotion)
{
    std::vector<double> positions;
    for (int i = 0; i < 5000; ++i) positions.push_back(1.1e-3 + (i % 3) * 2.2e-19);
    const EncoderStep found = estimate_encoder_step(positions);
    EXPECT_EQ(found.kind, StepKind::unknown);
    EXPECT_EQ(found.step, 0);
    EXPECT_EQ(found.changes, 0U);
}

} // namespace
} // namespace proxima::encoder_step_test
