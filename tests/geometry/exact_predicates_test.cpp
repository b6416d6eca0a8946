#include "geometry/exact_predicates.h"

#include "geometry/expansion.h"
#include "geometry/wide_integer.h"
#include "oracles/integer_overlap.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace proxima::exact_predicates_test {
namespace {

using oracle::Point;
using oracle::Wide;

int sign_of(Wide value)
{
    return (value > 0 ? 1 : 0) - (value < 0 ? 1 : 0);
}

// Small whole coordinates make every sign frequent, large ones fill the mantissa.
class PointGenerator {
public:
    explicit PointGenerator(std::uint64_t seed) : random_(seed) {}

    std::int64_t below(std::int64_t count)
    {
        return std::uniform_int_distribution<std::int64_t>(0, count - 1)(random_);
    }
    Point operator()(std::int64_t reach)
    {
        Point point;
        for (std::int64_t& component : point) component = below(2 * reach + 1) - reach;
        return point;
    }

private:
    std::mt19937_64 random_;
};

Vec3 to_double(const Point& point, const std::array<int, 3>& exponents)
{
    return {std::ldexp(static_cast<double>(point[0]), exponents[0]),
            std::ldexp(static_cast<double>(point[1]), exponents[1]),
            std::ldexp(static_cast<double>(point[2]), exponents[2])};
}

TEST(Orient3d, EqualsIntegersAtAnyExponents)
{
    constexpr std::uint64_t seed = 81;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    PointGenerator generate(seed);
    std::array<int, 3> seen = {};
    for (int i = 0; i < 80'000; ++i) {
        const std::int64_t reach = i % 2 == 0 ? 4 : std::int64_t{1} << 38;
        const Point a = generate(reach);
        const Point b = generate(reach);
        Point c = generate(reach);
        Point d = generate(reach);
        if (i % 4 == 1) { // in the plane or one unit beside it
            for (std::size_t k = 0; k < 3; ++k) d[k] = a[k] + 2 * (b[k] - a[k]) - (c[k] - a[k]);
            d[static_cast<std::size_t>(generate.below(3))] += generate.below(3) - 1;
        }
        if (i % 4 == 3) { // c collinear with a and b seen along z, or one unit beside it
            for (std::size_t k = 0; k < 2; ++k) c[k] = a[k] + 2 * (b[k] - a[k]);
            c[static_cast<std::size_t>(generate.below(2))] += generate.below(3) - 1;
        }
        const Point ab = oracle::subtract(b, a);
        const Point ac = oracle::subtract(c, a);
        const Point ad = oracle::subtract(d, a);
        const auto minor = [&](std::size_t u, std::size_t w) {
            return static_cast<Wide>(ab[u]) * ac[w] - static_cast<Wide>(ab[w]) * ac[u];
        };
        const Wide determinant = minor(1, 2) * ad[0] + minor(2, 0) * ad[1] + minor(0, 1) * ad[2];
        const int expected = sign_of(determinant);
        ++seen[expected < 0 ? 0U : expected == 0 ? 1U : 2U];
        std::array<int, 3> exponents = {0, 0, 0};
        if (i % 16 >= 12) {
            for (int& exponent : exponents)
                exponent = static_cast<int>(generate.below(2050)) - 1074;
        }
        const auto point = [&](const Point& p) { return to_double(p, exponents); };
        ASSERT_EQ(orient3d(point(a), point(b), point(c), point(d)), expected) << "case " << i;
        ASSERT_EQ(orient3d(point(b), point(a), point(c), point(d)), -expected) << "case " << i;
        const auto [size, truth] = in_common_units<2>(
            {exact_determinant({point(a), point(b)}, {point(a), point(c)}, {point(a), point(d)}),
             {static_cast<double>(determinant), exponents[0] + exponents[1] + exponents[2]}});
        ASSERT_EQ(size > 0, expected > 0) << "case " << i;
        ASSERT_NEAR(size, truth, 1e-15 * std::abs(truth)) << "case " << i;
        ASSERT_EQ(is_degenerate({{point(a), point(b), point(c)}}),
                  minor(1, 2) == 0 && minor(2, 0) == 0 && minor(0, 1) == 0)
            << "case " << i;
        ASSERT_EQ(orient2d(point(a).head<2>(), point(b).head<2>(), point(c).head<2>()),
                  sign_of(minor(0, 1)))
            << "case " << i;
    }
    for (const int count : seen) EXPECT_GT(count, 1'000);
}

TEST(DeterminantSign, OfASumEqualsIntegersAtAnyExponents)
{
    constexpr std::uint64_t seed = 82;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    PointGenerator generate(seed);
    std::array<int, 3> seen = {};
    std::array<int, 3> seen_across = {};
    for (int i = 0; i < 60'000; ++i) {
        const std::int64_t reach = i % 2 == 0 ? 4 : std::int64_t{1} << 34;
        const Point u = generate(reach);
        const Point v = generate(reach);
        const Point from = generate(reach);
        const std::int64_t scale = generate.below(9) - 4;
        const Point a = generate(reach);
        const Point b = generate(reach);
        Point w = generate(reach);
        if (i % 4 != 0) { // in the plane of u and v, along u, or one unit beside
            const std::int64_t along_v = i % 4 == 2 ? 0 : generate.below(5) - 2;
            const std::int64_t along_u = generate.below(5) - 2;
            for (std::size_t k = 0; k < 3; ++k) w[k] = along_u * u[k] + along_v * v[k];
            w[static_cast<std::size_t>(generate.below(3))] += generate.below(3) - 1;
        }
        std::array<int, 3> exponents = {0, 0, 0};
        if (i % 8 >= 5) {
            for (int& exponent : exponents)
                exponent = static_cast<int>(generate.below(2040)) - 1074;
        }
        const auto point = [&](const Point& p) { return to_double(p, exponents); };
        const auto displaced = [&](const Point& d) {
            Point to = from;
            for (std::size_t k = 0; k < 3; ++k) to[k] += d[k];
            return Displacement{point(from), point(to)};
        };
        Point start = a;
        for (std::size_t k = 0; k < 3; ++k) start[k] += scale * b[k] + w[k];
        const SumDisplacement sum{point(start), point(a), point(b), static_cast<double>(scale)};
        const auto minor = [](const Point& p, const Point& q, std::size_t k) {
            const std::size_t x = (k + 1) % 3;
            const std::size_t y = (k + 2) % 3;
            return static_cast<Wide>(p[x]) * q[y] - static_cast<Wide>(p[y]) * q[x];
        };
        const int expected =
            sign_of(minor(u, v, 0) * w[0] + minor(u, v, 1) * w[1] + minor(u, v, 2) * w[2]);
        ++seen[expected < 0 ? 0U : expected == 0 ? 1U : 2U];
        ASSERT_EQ(determinant_sign(displaced(u), displaced(v), sum), expected) << "case " << i;
        ASSERT_EQ(determinant_sign(displaced(v), displaced(u), sum), -expected) << "case " << i;
        for (int axis = 0; axis < 3; ++axis) {
            const int across = sign_of(minor(u, w, static_cast<std::size_t>(axis)));
            ++seen_across[across < 0 ? 0U : across == 0 ? 1U : 2U];
            ASSERT_EQ(cross_component_sign(displaced(u), sum, axis), across) << "case " << i;
            ASSERT_EQ(cross_component_sign(displaced(u), displaced(v), axis),
                      sign_of(minor(u, v, static_cast<std::size_t>(axis))))
                << "case " << i;
        }
    }
    for (const int count : seen) EXPECT_GT(count, 1'000);
    for (const int count : seen_across) EXPECT_GT(count, 1'000);
}

TEST(DeterminantSign, OfASumIsExactWhereOneTermIsTooSmallForTheFastArithmetic)
{
    // u fits it, the sum does not, and the other way round.
    const Displacement u{Vec3::Zero(), Vec3(1, 0, 0)};
    const Displacement v{Vec3::Zero(), Vec3(0, 1, 0)};
    for (const double tiny : {0x1p-1074, 0x1p-900}) {
        for (const double sign : {1.0, -1.0}) {
            const SumDisplacement above{Vec3(1, 1, sign * tiny), Vec3::Zero(), Vec3(1, 1, 0), 1};
            EXPECT_EQ(determinant_sign(u, v, above), static_cast<int>(sign));
            const SumDisplacement across{Vec3(0, sign * tiny, 0), Vec3::Zero(), Vec3::Zero(), 1};
            EXPECT_EQ(cross_component_sign(u, across, 2), static_cast<int>(sign));
            const Displacement small{Vec3::Zero(), Vec3(tiny, 0, 0)};
            const SumDisplacement large{Vec3(0, 1, 0), Vec3::Zero(), Vec3(0, sign > 0 ? 0 : 2, 0),
                                        1};
            EXPECT_EQ(cross_component_sign(small, large, 2), static_cast<int>(sign));
        }
    }
    // (1 + e)^2 beside 1 + 2 e, times a number so small that doubles do not hold e^2 times it.
    constexpr double e = 0x1p-52;
    constexpr double small = 0x1p-1000;
    const Displacement slope{Vec3::Zero(), Vec3(1 + e, 1, 0)};
    for (const double sign : {1.0, -1.0}) {
        const SumDisplacement other{sign * small * Vec3(1 + 2 * e, 1 + e, 0), Vec3::Zero(),
                                    Vec3::Zero(), 1};
        EXPECT_EQ(cross_component_sign(slope, other, 2), static_cast<int>(sign));
        const Displacement low{Vec3::Zero(), small * Vec3(1 + e, 1, 0)};
        const SumDisplacement high{sign * Vec3(1 + 2 * e, 1 + e, 0), Vec3::Zero(), Vec3::Zero(), 1};
        EXPECT_EQ(cross_component_sign(low, high, 2), static_cast<int>(sign));
    }
}

TEST(CrossComponentSign, IsExactWhereOnlyOneFactorSuitsTheFastArithmetic)
{
    // 2^-200 and 2^-1000: their product is no number of double precision.
    const auto along = [](int axis, double length) { return Vec3(length * Vec3::Unit(axis)); };
    for (int axis = 0; axis < 3; ++axis) {
        const int p = (axis + 1) % 3;
        const int q = (axis + 2) % 3;
        for (const auto& [of_u, of_w] : {std::pair(0x1p-200, 0x1p-1000), {0x1p-1000, 0x1p-200}}) {
            const SumDisplacement w = {along(q, of_w), Vec3::Zero(), Vec3::Zero(), 1};
            EXPECT_EQ(cross_component_sign({Vec3::Zero(), along(p, of_u)}, w, axis), 1) << axis;
            EXPECT_EQ(cross_component_sign({along(p, of_u), Vec3::Zero()}, w, axis), -1) << axis;
        }
    }
}

TEST(UnitNormal, IsRightWhereRoundedProductsCancel)
{
    // (1 + e)^2 - (1 + 2e) is e^2, and rounds to 0.
    constexpr double e = 0x1p-52;
    for (int axis = 0; axis < 3; ++axis) {
        const int p = (axis + 1) % 3;
        const int q = (axis + 2) % 3;
        Vec3 u = Vec3::Zero();
        Vec3 v = Vec3::Zero();
        u[p] = 1 + e;
        u[q] = 1 + 2 * e;
        v[p] = 1;
        v[q] = 1 + e;
        EXPECT_EQ(unit_normal({Vec3::Zero(), u}, {Vec3::Zero(), v}), Vec3::Unit(axis)) << axis;
        EXPECT_EQ(unit_normal({Vec3::Zero(), v}, {Vec3::Zero(), u}), -Vec3::Unit(axis)) << axis;
        // The same sign by the determinant with a sum.
        const SumDisplacement across = {Vec3::Unit(axis), Vec3::Zero(), Vec3::Zero(), 1};
        EXPECT_EQ(determinant_sign({Vec3::Zero(), u}, {Vec3::Zero(), v}, across), 1) << axis;
    }
}

// Found by a fuzzer: a proxy passed a needle whose width is the smallest double, for its normal was wrong.
TEST(UnitNormal, IsRightWherePartsAreFarTooSmallBesideTheOthers)
{
    std::mt19937_64 random(11);
    std::uniform_int_distribution<int> number(-1000, 1000);
    std::uniform_int_distribution<int> exponent(-1074, -300);
    for (int i = 0; i < 2000; ++i) {
        // v = w + tiny, which no double holds, is all but parallel to w.
        const Vec3 w = Vec3(number(random), number(random), number(random)) / 1024.0;
        const Vec3 digits(number(random), number(random), number(random));
        const Vec3 tiny = digits * std::ldexp(1.0, exponent(random));
        const Vec3 across = w.cross(digits); // exact
        const Vec3 expected = across.isZero() ? across : across.normalized();
        const Vec3 found = unit_normal({Vec3::Zero(), w}, {-w, tiny});
        EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-15) << i;
        EXPECT_EQ(unit_normal({-w, tiny}, {Vec3::Zero(), w}), -found) << i;
    }
    // A part of one direction that no other one has.
    const double least = std::numeric_limits<double>::denorm_min();
    EXPECT_EQ(unit_normal({Vec3::Zero(), {0.25, 0, 0}}, {Vec3::Zero(), {0.5, 0, least}}),
              -Vec3::UnitY());
}

TEST(UnitNormal, IsRightWhereProductsLoseDigitsAtTheEndOfDoubles)
{
    std::mt19937_64 random(12);
    std::uniform_int_distribution<int> number(-7, 7);
    std::uniform_int_distribution<int> exponent(-1071, -850);
    for (int i = 0; i < 2000; ++i) {
        // u x v = (0, -u_x v_z, u_x v_y): products of which doubles hold a digit or none.
        const Vec3 u(number(random) / 8.0, 0, 0);
        const Vec3 digits(0, number(random), number(random));
        const Vec3 v = number(random) * Vec3::UnitX() + digits * std::ldexp(1.0, exponent(random));
        const Vec3 across = u.cross(digits); // exact
        const Vec3 expected = across.isZero() ? across : across.normalized();
        const Vec3 found = unit_normal({Vec3::Zero(), u}, {Vec3::Zero(), v});
        EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-15) << i;
    }
}

TEST(IsDegenerate, DistinguishesLinesAndPointsFromSlivers)
{
    const Vec3 a(0.1, 0.2, 0.3);
    const Vec3 b(0.7, 0.8, 0.9);
    EXPECT_TRUE(is_degenerate({{a, a, a}}));
    EXPECT_TRUE(is_degenerate({{a, b, a}}));
    EXPECT_TRUE(is_degenerate({{Vec3(0, 0, 0), Vec3(0.1, 0.1, 0.1), Vec3(0.7, 0.7, 0.7)}}));
    EXPECT_FALSE(is_degenerate(
        {{Vec3(0, 0, 0), Vec3(0.1, 0.1, 0.1), Vec3(0.7, 0.7, std::nextafter(0.7, 1.0))}}));
    EXPECT_FALSE(is_degenerate({{Vec3(1e-300, 0, 0), Vec3(0, 1e-300, 0), Vec3(0, 0, 1e-300)}}));
}

// The grid of doubles around a line, where rounded arithmetic gives a famous mosaic of wrong signs.
TEST(Orient2d, IsConsistentWithinUlpsOfALine)
{
    const Vec2 from(12, 12);
    const Vec2 to(24, 24);
    for (int i = 0; i < 64; ++i) {
        for (int j = 0; j < 64; ++j) {
            const Vec2 point(0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53);
            const int expected = (point.y() > point.x() ? 1 : 0) - (point.y() < point.x() ? 1 : 0);
            ASSERT_EQ(orient2d(from, to, point), expected) << i << ' ' << j;
            ASSERT_EQ(orient2d(to, point, from), expected) << i << ' ' << j;
            // From the point both differences are rounded.
            ASSERT_EQ(orient2d(point, from, to), expected) << i << ' ' << j;
        }
    }
}

RC_GTEST_PROP(Expansion, ProductsOfDifferencesEqualWideIntegers, ())
{
    const auto number = [] {
        const auto mantissa = static_cast<double>(
            *rc::gen::inRange<std::int64_t>(-(std::int64_t{1} << 53), std::int64_t{1} << 53));
        return std::ldexp(mantissa, *rc::gen::inRange(-280, 240));
    };
    const double a = number();
    const double b = number();
    const double c = number();
    const double d = number();
    const auto by_expansion = detail::exact_difference(a, b) * detail::exact_difference(c, d) *
                                  detail::exact_difference(a, d) -
                              detail::exact_difference(b, c) * detail::exact_difference(b, d) *
                                  detail::exact_difference(a, c);
    using detail::WideInteger;
    const WideInteger wa(a);
    const WideInteger wb(b);
    const WideInteger wc(c);
    const WideInteger wd(d);
    const WideInteger expected =
        (wa - wb) * (wc - wd) * (wa - wd) - (wb - wc) * (wb - wd) * (wa - wc);
    // Not only the sign: the expansion's components add up to the very number.
    WideInteger sum;
    const WideInteger one(1.0);
    const WideInteger unit = one * one; // scale of a product of three relative to one component
    for (int i = 0; i < by_expansion.size(); ++i) sum = sum + WideInteger(by_expansion[i]) * unit;
    RC_ASSERT((sum - expected).sign() == 0);
    RC_ASSERT(by_expansion.sign() == expected.sign());
}

TEST(WideInteger, AgreesWithMachineIntegers)
{
    constexpr std::uint64_t seed = 82;
    PointGenerator generate(seed);
    const double unit = std::numeric_limits<double>::denorm_min();
    for (int i = 0; i < 20'000; ++i) {
        const Point p = generate(std::int64_t{1} << (1 + i % 50));
        const auto wide = [&](std::size_t k) {
            return detail::WideInteger(static_cast<double>(p[k]) * unit);
        };
        const Wide expected = static_cast<Wide>(p[0]) * p[1] - static_cast<Wide>(p[2]) * p[1] +
                              static_cast<Wide>(p[0]) - p[2];
        const detail::WideInteger value = wide(0) * wide(1) - wide(2) * wide(1) + wide(0) - wide(2);
        ASSERT_EQ(value.sign(), sign_of(expected)) << "seed " << seed << " case " << i;
        // The very number, from halves that doubles hold.
        const auto part = [&](Wide of) {
            return detail::WideInteger(static_cast<double>(of) * unit);
        };
        const Wide base = Wide{1} << 51;
        const detail::WideInteger same = part(expected / base) * part(base) + part(expected % base);
        ASSERT_EQ((value - same).sign(), 0) << "seed " << seed << " case " << i;
    }
}

} // namespace
} // namespace proxima::exact_predicates_test
