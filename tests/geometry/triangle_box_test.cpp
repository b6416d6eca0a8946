#include "geometry/triangle_box.h"

#include "oracles/integer_overlap.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

namespace proxima::triangle_box_test {
namespace {

using oracle::IntegerPair;
using oracle::PairGenerator;

struct Exponents {
    std::array<int, 3> axis = {0, 0, 0};
};

Vec3 scaled_point(const oracle::Point& point, const Exponents& exponents)
{
    return {std::ldexp(static_cast<double>(point[0]), exponents.axis[0]),
            std::ldexp(static_cast<double>(point[1]), exponents.axis[1]),
            std::ldexp(static_cast<double>(point[2]), exponents.axis[2])};
}

Triangle triangle_of(const IntegerPair& pair, const Exponents& exponents = {})
{
    const auto& v = pair.triangle.vertices;
    return {{scaled_point(v[0], exponents), scaled_point(v[1], exponents),
             scaled_point(v[2], exponents)}};
}

Box box_of(const IntegerPair& pair, const Exponents& exponents = {})
{
    return {scaled_point(pair.box.lower, exponents), scaled_point(pair.box.upper, exponents)};
}

struct Tally {
    int overlapping = 0;
    int apart = 0;
    int certain = 0;
};

// Compares both answers with the oracle; stops the test at the first difference.
void compare_with_oracle(std::uint64_t seed, std::int64_t size, int pairs, Tally& tally)
{
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", grid 0.." << size);
    PairGenerator generate(seed, size);
    for (int i = 0; i < pairs; ++i) {
        const IntegerPair pair = generate();
        const bool expected = oracle::overlaps(pair.triangle, pair.box);
        ASSERT_EQ(triangle_overlaps_box(triangle_of(pair), box_of(pair)), expected) << "pair " << i;
        const TriangleBoxVerdict verdict = triangle_box_filter(triangle_of(pair), box_of(pair));
        ASSERT_EQ(verdict.overlaps, expected || !verdict.certain) << "pair " << i;
        (expected ? tally.overlapping : tally.apart) += 1;
        tally.certain += verdict.certain ? 1 : 0;
    }
}

TEST(TriangleBox, EqualsIntegerOracleOnTouchingGrids)
{
    Tally tally;
    for (const std::int64_t size : {1, 2, 4, 8}) compare_with_oracle(71, size, 150'000, tally);
    EXPECT_GT(tally.overlapping, 100'000);
    EXPECT_GT(tally.apart, 100'000);
}

TEST(TriangleBox, EqualsIntegerOracleOnLargeGrids)
{
    Tally tally;
    // The last one is beyond what products of two differences hold in a double.
    for (const int bits : {7, 14, 20, 38})
        compare_with_oracle(72, std::int64_t{1} << bits, 150'000, tally);
    EXPECT_GT(tally.overlapping, 100'000);
    EXPECT_GT(tally.apart, 100'000);
}

// Scaling an axis by a power of two moves no point into or out of anything.
TEST(TriangleBox, HoldsForAnyExponents)
{
    constexpr std::uint64_t seed = 73;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    PairGenerator generate(seed, 64);
    for (int i = 0; i < 20'000; ++i) {
        const IntegerPair pair = generate();
        Exponents exponents;
        // Whole range of doubles (subnormal to nearly infinite), and the ends of the expansions'.
        for (int& exponent : exponents.axis) {
            switch (generate.below(4)) {
            case 0:
                exponent = static_cast<int>(generate.below(2080)) - 1070;
                break;
            case 1:
                exponent = 280 + static_cast<int>(generate.below(20));
                break;
            case 2:
                exponent = -295 + static_cast<int>(generate.below(20));
                break;
            default:
                exponent = -1070 + static_cast<int>(generate.below(30));
                break;
            }
        }
        // Where a product of three coordinates is about the largest double.
        if (i % 4 == 0) exponents.axis.fill(333 + static_cast<int>(generate.below(6)));
        const bool expected = oracle::overlaps(pair.triangle, pair.box);
        const Triangle triangle = triangle_of(pair, exponents);
        const Box box = box_of(pair, exponents);
        ASSERT_EQ(triangle_overlaps_box(triangle, box), expected)
            << "pair " << i << " exponents " << exponents.axis[0] << ' ' << exponents.axis[1] << ' '
            << exponents.axis[2];
        const TriangleBoxVerdict verdict = triangle_box_filter(triangle, box);
        ASSERT_EQ(verdict.overlaps, expected || !verdict.certain) << "pair " << i;
    }
}

TEST(TriangleBox, SurvivesDifferencesThatOverflow)
{
    const double huge = std::numeric_limits<double>::max();
    const Box box = {Vec3::Constant(-huge), Vec3::Constant(huge)};
    const Triangle around = {{Vec3(-huge, huge, 0), Vec3(huge, huge, 0), Vec3(0, huge, huge)}};
    EXPECT_TRUE(triangle_overlaps_box(around, box));
    const Box corner = {Vec3::Constant(0.75 * huge), Vec3::Constant(huge)};
    const Triangle cut = {{Vec3(huge, 0, 0), Vec3(0, huge, 0), Vec3(0, 0, huge)}};
    EXPECT_FALSE(triangle_overlaps_box(cut, corner));
    const Triangle beyond = {
        {Vec3(huge, 0.7 * huge, huge), Vec3(0.7 * huge, huge, huge), Vec3(huge, huge, 0.7 * huge)}};
    EXPECT_TRUE(triangle_overlaps_box(beyond, corner));
}

TEST(TriangleBox, FilterIsCertainOfTouchingPairsParallelToAxes)
{
    const Box box = {Vec3(0.1, 0.2, 0.3), Vec3(0.4, 0.5, 0.6)};
    const Triangle on_face = {{Vec3(0.4, 0, 0), Vec3(0.4, 1, 0.1), Vec3(0.4, 0.3, 1)}};
    const TriangleBoxVerdict verdict = triangle_box_filter(on_face, box);
    EXPECT_TRUE(verdict.certain);
    EXPECT_TRUE(verdict.overlaps);
    const double beyond = std::nextafter(0.4, 1.0);
    const Triangle beside = {{Vec3(beyond, 0, 0), Vec3(beyond, 1, 0.1), Vec3(beyond, 0.3, 1)}};
    EXPECT_TRUE(triangle_box_filter(beside, box).certain);
    EXPECT_FALSE(triangle_box_filter(beside, box).overlaps);
}

// An edge that passes a box's edge within ulps, from a place where all differences are rounded.
TEST(TriangleBox, IsExactWithinUlpsOfAnEdge)
{
    const Box box = {Vec3(24, 18, -1), Vec3(30, 24, 1)};
    for (int i = 0; i < 64; ++i) {
        for (int j = 0; j < 64; ++j) {
            const Vec3 start(0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53, 0);
            const Triangle triangle = {{start, Vec3(48, 48, 0), Vec3(0.5, 40, 0)}};
            const bool expected = start.y() <= start.x();
            ASSERT_EQ(triangle_overlaps_box(triangle, box), expected) << i << ' ' << j;
            const TriangleBoxVerdict verdict = triangle_box_filter(triangle, box);
            ASSERT_EQ(verdict.overlaps, expected || !verdict.certain) << i << ' ' << j;
        }
    }
}

TEST(TriangleBox, FilterDecidesNearlyAllRandomPairs)
{
    constexpr std::uint64_t seed = 74;
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> coordinate(-1, 1);
    const auto point = [&] {
        return Vec3{coordinate(random), coordinate(random), coordinate(random)};
    };
    const Box box = {Vec3::Constant(-0.25), Vec3::Constant(0.25)};
    int uncertain = 0;
    for (int i = 0; i < 100'000; ++i)
        uncertain += triangle_box_filter({{point(), point(), point()}}, box).certain ? 0 : 1;
    EXPECT_EQ(uncertain, 0) << "seed " << seed;
}

RC_GTEST_PROP(TriangleBox, IgnoresOrderOfCornersAndAxesAndReflection, (std::uint64_t seed))
{
    PairGenerator generate(seed, 6);
    const IntegerPair pair = generate();
    const Triangle triangle = triangle_of(pair);
    const Box box = box_of(pair);
    const bool expected = triangle_overlaps_box(triangle, box);
    RC_ASSERT(triangle_overlaps_box({{triangle[1], triangle[2], triangle[0]}}, box) == expected);
    RC_ASSERT(triangle_overlaps_box({{triangle[1], triangle[0], triangle[2]}}, box) == expected);
    const auto rotate = [](const Vec3& p) { return Vec3(p.y(), p.z(), p.x()); };
    RC_ASSERT(
        triangle_overlaps_box({{rotate(triangle[0]), rotate(triangle[1]), rotate(triangle[2])}},
                              {rotate(box.lower), rotate(box.upper)}) == expected);
    RC_ASSERT(triangle_overlaps_box({{-triangle[0], -triangle[1], -triangle[2]}},
                                    {-box.upper, -box.lower}) == expected);
}

} // namespace
} // namespace proxima::triangle_box_test
