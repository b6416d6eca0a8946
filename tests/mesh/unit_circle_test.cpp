#include "mesh/unit_circle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

namespace proxima::unit_circle_test {
namespace {

TEST(UnitCircle, IsTheRoundedSineAndCosine)
{
    for (const std::uint32_t count : {1U, 2U, 3U, 7U, 8U, 50U, 100U, 199U, 1000U, 4294967295U}) {
        for (std::uint32_t k = 0; k < 1000; ++k) {
            const std::uint32_t step = count <= 1000 ? k % count : k * 4294967U;
            const long double angle = 2.0L * std::numbers::pi_v<long double> *
                                      static_cast<long double>(step) /
                                      static_cast<long double>(count);
            const auto [cosine, sine] = unit_circle(step, count);
            // Half a step of rounding, and the error of the reference itself.
            const double bound = std::ldexp(1.0, -41) + 1e-15;
            EXPECT_NEAR(cosine, static_cast<double>(std::cos(angle)), bound)
                << step << '/' << count;
            EXPECT_NEAR(sine, static_cast<double>(std::sin(angle)), bound) << step << '/' << count;
            EXPECT_EQ(std::ldexp(cosine, 40), std::round(std::ldexp(cosine, 40)));
            EXPECT_EQ(std::ldexp(sine, 40), std::round(std::ldexp(sine, 40)));
        }
    }
}

TEST(UnitCircle, IsExactOnTheAxesAndDiagonals)
{
    const auto expect = [](std::uint32_t step, double cosine, double sine) {
        const CirclePoint point = unit_circle(step, 8);
        EXPECT_EQ(point.cosine, cosine) << step;
        EXPECT_EQ(point.sine, sine) << step;
        EXPECT_EQ(std::signbit(point.cosine), cosine < 0.0) << step;
        EXPECT_EQ(std::signbit(point.sine), sine < 0.0) << step;
    };
    const double diagonal = unit_circle(1, 8).cosine;
    EXPECT_NEAR(diagonal, std::sqrt(0.5), std::ldexp(1.0, -41));
    expect(0, 1, 0);
    expect(1, diagonal, diagonal);
    expect(2, 0, 1);
    expect(3, -diagonal, diagonal);
    expect(4, -1, 0);
    expect(5, -diagonal, -diagonal);
    expect(6, 0, -1);
    expect(7, diagonal, -diagonal);
}

TEST(UnitCircle, MirrorImagesAreExact)
{
    for (const std::uint32_t count : {4U, 100U, 204U}) {
        for (std::uint32_t step = 0; step < count; ++step) {
            const CirclePoint point = unit_circle(step, count);
            const CirclePoint below = unit_circle(count - step, count);
            const CirclePoint left = unit_circle(count + count / 2 - step, count);
            const CirclePoint turned = unit_circle(step + count / 4, count);
            EXPECT_EQ(point.cosine, below.cosine);
            EXPECT_EQ(point.sine, -below.sine);
            EXPECT_EQ(point.cosine, -left.cosine);
            EXPECT_EQ(point.sine, left.sine);
            EXPECT_EQ(point.cosine, turned.sine);
            EXPECT_EQ(point.sine, -turned.cosine);
        }
    }
}

TEST(UnitCircle, ProductsOnItsGridAreMultiplesOfItsStep)
{
    for (std::uint32_t step = 0; step < 199; ++step) {
        const CirclePoint point = unit_circle(step, 199);
        const double product = point.cosine * point.sine;
        const double rounded = on_circle_grid(product);
        EXPECT_EQ(rounded, std::ldexp(std::nearbyint(std::ldexp(product, 40)), -40));
        EXPECT_FALSE(rounded == 0.0 && std::signbit(rounded));
    }
    EXPECT_EQ(on_circle_grid(unit_circle(3, 20).sine * unit_circle(1, 5).cosine), 0.25);
    EXPECT_FALSE(std::signbit(on_circle_grid(-0.0)));
    EXPECT_EQ(on_circle_grid(-1.0), -1.0);
}

} // namespace
} // namespace proxima::unit_circle_test
