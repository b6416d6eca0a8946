#include "geometry/length.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace proxima::length_test {
namespace {

TEST(LengthOf, IsRightOverTheWholeRangeOfDoubles)
{
    const unsigned seed = 31;
    RecordProperty("seed", static_cast<int>(seed));
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::uniform_int_distribution<int> exponent(-1060, 1022);
    for (int i = 0; i < 100000; ++i) {
        const int scale = exponent(random);
        Vec3 v;
        for (double& coordinate : v)
            coordinate = std::ldexp(unit(random), scale - (i % 5 == 0 ? exponent(random) / 20 : 0));
        // The long doubles' exponents reach far beyond the doubles' squares.
        using Wide = Eigen::Matrix<long double, 3, 1>;
        const Wide wide = v.cast<long double>();
        const long double truth =
            std::sqrt(wide.x() * wide.x() + wide.y() * wide.y() + wide.z() * wide.z());
        if (truth > std::numeric_limits<double>::max()) continue;
        const long double ulp =
            std::nextafter(static_cast<double>(truth), HUGE_VAL) - static_cast<double>(truth);
        ASSERT_LE(std::abs(length_of(v) - truth), 2 * ulp) << v.transpose() << ", seed " << seed;
    }
}

TEST(LengthOf, IsScaledExactlyByPowersOfTwo)
{
    std::mt19937_64 random(32);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 10000; ++i) {
        const Vec3 v(unit(random), unit(random), unit(random));
        // Past the ends of what is computed directly.
        ASSERT_EQ(length_of(Vec3(v * 0x1p-600)), length_of(v) * 0x1p-600);
        ASSERT_EQ(length_of(Vec3(v * 0x1p+600)), length_of(v) * 0x1p+600);
    }
}

TEST(LengthOf, SaysWhereACoordinateIsNotFinite)
{
    const double infinity = std::numeric_limits<double>::infinity();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(length_of({0, 0, 0}), 0);
    EXPECT_EQ(length_of({0, -infinity, 1}), infinity);
    EXPECT_TRUE(std::isnan(length_of({0, 1, nan})));
    EXPECT_TRUE(std::isnan(length_of({nan, 1e300, 1e300})));
    EXPECT_EQ(length_of({std::numeric_limits<double>::denorm_min(), 0, 0}),
              std::numeric_limits<double>::denorm_min());
    EXPECT_EQ(length_of({std::numeric_limits<double>::max(), 0, 0}),
              std::numeric_limits<double>::max());
}

TEST(UnitOf, HasTheSameBitsForAVectorTimesAnyPowerOfTwo)
{
    const unsigned seed = 33;
    RecordProperty("seed", static_cast<int>(seed));
    std::mt19937_64 random(seed);
    std::uniform_int_distribution<int> number(-255, 255);
    for (int i = 0; i < 1000; ++i) {
        const Vec3 v(number(random), number(random), number(random));
        const Vec3 expected = v.isZero() ? v : v.normalized();
        for (int exponent = -1074; exponent <= 1015; exponent += 1 + i % 7) {
            const Vec3 scaled(std::ldexp(v.x(), exponent), std::ldexp(v.y(), exponent),
                              std::ldexp(v.z(), exponent));
            const Vec3 found = unit_of(scaled);
            ASSERT_LE((found - expected).cwiseAbs().maxCoeff(), 0x1p-52) << exponent;
            ASSERT_EQ(found, unit_of(v)) << v.transpose() << " times 2^" << exponent;
        }
    }
}

TEST(UnitOf, LeavesWhatHasNoDirection)
{
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(unit_of(Vec3::Zero()), Vec3::Zero());
    EXPECT_FALSE(unit_of({0, infinity, 1}).allFinite());
    EXPECT_FALSE(unit_of({0, 1, std::numeric_limits<double>::quiet_NaN()}).allFinite());
}

} // namespace
} // namespace proxima::length_test
