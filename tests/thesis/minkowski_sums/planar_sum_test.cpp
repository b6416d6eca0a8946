// Planar sums against a brute force in 128-bit whole numbers: the hull of all sums of two corners.
#include "code_of.h"
#include "thesis/minkowski_sums/whole_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace proxima::planar_sum_test {
namespace {

using namespace testing;

/// Corners of the hull, counter-clockwise, by wrapping: the next corner has all others to the left.
std::vector<Whole> hull_of(const std::vector<Whole>& points)
{
    std::vector<Whole> hull = {*std::ranges::min_element(points)};
    while (true) {
        const Whole& at = hull.back();
        Whole next = at;
        for (const Whole& p : points) {
            const Wide turn = cross(next - at, p - at);
            if (next == at || turn < 0 ||
                (turn == 0 && dot(p - at, p - at) > dot(next - at, next - at)))
                next = p;
        }
        if (next == hull.front()) return hull;
        hull.push_back(next);
    }
}

/// Whole points whose polygons are points, segments, have parallel edges, or are general.
Points nasty_points(std::mt19937_64& random)
{
    const auto below = [&](std::int64_t n) {
        return std::uniform_int_distribution<std::int64_t>(0, n - 1)(random);
    };
    const std::array<std::int64_t, 5> reaches = {1, 2, 5, 1000, std::int64_t{1} << 53U};
    const std::int64_t reach = reaches[static_cast<std::size_t>(below(5))];
    const auto coordinate = [&] { return static_cast<double>(below(2 * reach + 1) - reach); };
    Points points(static_cast<std::size_t>(1 + below(9)));
    for (Vec2& point : points) {
        point.x() = coordinate();
        point.y() = coordinate();
    }
    return points;
}

/// As nasty_points, or the other's points turned by half, moved, or moved by one unit here and
/// there: edges parallel, or so nearly that products of doubles do not tell.
Points nasty_partner(std::mt19937_64& random, const Points& other)
{
    const auto below = [&](std::int64_t n) {
        return std::uniform_int_distribution<std::int64_t>(0, n - 1)(random);
    };
    const auto way = below(4);
    if (way == 0) return nasty_points(random);
    Points points = other;
    const double sign = way == 1 ? -1 : 1;
    for (Vec2& point : points) {
        point *= sign;
        if (way == 3 && below(3) == 0) point[below(2)] -= sign * std::copysign(1.0, point[0]);
    }
    return points;
}

TEST(PlanarSum, HasTheEdgesOfTheHullOfAllPairs)
{
    int with_parallel = 0;
    for (unsigned seed = 0; seed < 20000; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        const Points points_a = nasty_points(random);
        const Points points_b = nasty_partner(random, points_a);
        const PlanarSum sum = sum_of(polygon_of(points_a), polygon_of(points_b));

        std::vector<Whole> all;
        for (const Vec2& p : points_a)
            for (const Vec2& q : points_b) all.push_back(whole(p) + whole(q));
        const std::vector<Whole> hull = hull_of(all);
        const std::size_t expected = hull.size() == 1 ? 0 : hull.size();
        ASSERT_EQ(sum.edges().size(), expected);
        if (expected == 0) continue;

        const auto start = std::ranges::find(hull, exact_point(sum, sum.edges()[0].from));
        ASSERT_NE(start, hull.end());
        auto at = static_cast<std::size_t>(start - hull.begin());
        for (const PlanarEdge& edge : sum.edges()) {
            EXPECT_EQ(exact_point(sum, edge.from), hull[at]);
            at = (at + 1) % hull.size();
            EXPECT_EQ(exact_point(sum, edge.to), hull[at]);
            EXPECT_EQ(edge.support, edge.to);
            EXPECT_FALSE(edge.from_infinity || edge.to_infinity);
            EXPECT_EQ(edge.offset,
                      edge.normal.dot(sum.points()[static_cast<std::size_t>(edge.to)]));
            EXPECT_NEAR(edge.normal.norm(), 1, 1e-15);
            with_parallel += edge.origin == FacetOrigin::both ? 1 : 0;
        }
        for (std::size_t e = 0; e < expected; ++e) { // index pairs, not only points, follow
            EXPECT_EQ(sum.edges()[e].to, sum.edges()[(e + 1) % expected].from);
        }
        EXPECT_EQ(sum.lines().size(),
                  static_cast<std::size_t>(sum.a().edge_count() + sum.b().edge_count()));
    }
    EXPECT_GT(with_parallel, 5000);
}

TEST(PlanarSum, LinesTouchTheFarthestPoints)
{
    for (unsigned seed = 0; seed < 3000; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        const Points points_a = nasty_points(random);
        const PlanarSum sum =
            sum_of(polygon_of(points_a), polygon_of(nasty_partner(random, points_a)));
        double reach = 0;
        for (const Vec2& point : sum.points()) reach = std::max(reach, point.norm());
        for (const PushedLine& line : sum.lines()) {
            ASSERT_GE(line.edge, 0);
            EXPECT_TRUE(line.spans_edge);
            const PlanarEdge& edge = sum.edges()[static_cast<std::size_t>(line.edge)];
            const auto touched = sum.touched(line);
            for (const int k : {edge.from, edge.to, line.support})
                EXPECT_NE(std::ranges::find(touched, k), touched.end());
            for (const Vec2& point : sum.points())
                EXPECT_LE(line.normal.dot(point), line.offset + 1e-15 * reach);
            EXPECT_TRUE(edge.origin == line.origin || edge.origin == FacetOrigin::both);
        }
    }
}

/// Thesis 3.2 and 3.5: a triangle and a rectangle, Figures 3.1 to 3.6 and 3.14.
class ThesisExample : public ::testing::Test {
protected:
    const ConvexPolygon rectangle = polygon_of({{-2, -1}, {2, -1}, {2, 1}, {-2, 1}});
    const ConvexPolygon triangle = polygon_of({{1, 4}, {-3, -2}, {4, -3}});
};

TEST_F(ThesisExample, HasSevenNormalsAndTwelvePoints)
{
    const PlanarSum sum = sum_of(rectangle, triangle);
    EXPECT_EQ(sum.points().size(), 12U);
    ASSERT_EQ(sum.lines().size(), 7U);
    EXPECT_EQ(sum.edges().size(), 7U);
    for (std::size_t i = 0; i < 7; ++i) { // n1 to n3 of the triangle, n4 to n7 of the rectangle
        EXPECT_EQ(sum.lines()[i].origin, i < 3 ? FacetOrigin::b : FacetOrigin::a);
        EXPECT_EQ(sum.touched(sum.lines()[i]).size(), 2U);
    }
    for (int k = 0; k < 12; ++k) {
        const Vec2 expected = rectangle.points()[static_cast<std::size_t>(k % 4)] +
                              triangle.points()[static_cast<std::size_t>(k / 4)];
        EXPECT_EQ(sum.points()[static_cast<std::size_t>(k)], expected);
    }
}

TEST_F(ThesisExample, IndexSevenIsCornerThreeOfTheRectangleAndOneOfTheTriangle)
{
    const PlanarSum sum = sum_of(rectangle, triangle);
    const PushedLine& line = sum.lines()[0]; // of the triangle's edge from 0 to 1: the grey one
    const PlanarEdge& edge = sum.edges()[static_cast<std::size_t>(line.edge)];
    EXPECT_EQ(edge.from, 3);
    EXPECT_EQ(edge.to, 7);
    EXPECT_EQ(edge.support, 7);
    EXPECT_EQ(sum.pair(7), (CornerPair{3, 1}));
    EXPECT_EQ(sum.index({3, 1}), 7);
}

TEST_F(ThesisExample, IndexTrackingFindsTheEdgesOfEverySize)
{
    const PlanarSum sum = sum_of(rectangle, triangle);
    for (const double scale : {0.5, 0.25, 0.125, 4.0}) {
        Points smaller;
        for (const Vec2& point : rectangle.points()) smaller.emplace_back(scale * point);
        const PlanarSum anew = sum_of(polygon_of(smaller), triangle);
        ASSERT_EQ(anew.edges().size(), sum.edges().size());
        for (std::size_t e = 0; e < sum.edges().size(); ++e) {
            const PlanarEdge& edge = sum.edges()[e];
            EXPECT_EQ(edge.support, anew.edges()[e].support);
            EXPECT_EQ(edge.from, anew.edges()[e].from);
            EXPECT_EQ(edge.to, anew.edges()[e].to);
            EXPECT_EQ(sum.point(edge.to, {.a = scale}),
                      anew.points()[static_cast<std::size_t>(edge.to)]);
            EXPECT_EQ(sum.offset(edge, {.a = scale}), anew.edges()[e].offset);
        }
    }
}

TEST(PlanarSum, RefusesInvalidInput)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(code_of(convex_polygon({})), ErrorCode::invalid_argument);
    EXPECT_EQ(code_of(convex_polygon(Points{{0, nan}})), ErrorCode::invalid_argument);
    EXPECT_EQ(code_of(convex_polygon(Points{{0, 1e200}})), ErrorCode::limit_exceeded);
    const Points origin = {{0, 0}};
    EXPECT_EQ(code_of(convex_polygon(origin, Points{{0, 0}})), ErrorCode::invalid_argument);
    EXPECT_EQ(code_of(convex_polygon(origin, Points{{1, 2}, {-1, -2}})),
              ErrorCode::invalid_argument);
    EXPECT_EQ(code_of(convex_polygon(origin, Points{{1, 0}, {-1, 1}, {-1, -1}})),
              ErrorCode::invalid_argument);
    EXPECT_TRUE(convex_polygon(origin, Points{{1, 0}, {2, 0}, {-1, 1e-300}}));
    const ConvexPolygon point = polygon_of(origin);
    for (const double length : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
        EXPECT_EQ(code_of(planar_sum(point, point, {.cut_length = length})),
                  ErrorCode::invalid_argument);
    }
    EXPECT_TRUE(sum_of(point, point).edges().empty());
}

/// Products underflow at 1e-170, and are large at 1e80; edges do not change.
TEST(PlanarSum, HasTheSameEdgesAtAnyScale)
{
    for (unsigned seed = 0; seed < 500; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        const Points points_a = nasty_points(random);
        const Points points_b = nasty_partner(random, points_a);
        const PlanarSum plain_sum = sum_of(polygon_of(points_a), polygon_of(points_b));
        for (const int exponent : {-600, 240}) {
            const auto scaled = [&](Points points) {
                for (Vec2& point : points) point *= std::ldexp(1.0, exponent);
                return polygon_of(points);
            };
            const PlanarSum sum = sum_of(scaled(points_a), scaled(points_b));
            ASSERT_EQ(sum.edges().size(), plain_sum.edges().size());
            for (std::size_t e = 0; e < sum.edges().size(); ++e) {
                EXPECT_EQ(sum.edges()[e].from, plain_sum.edges()[e].from);
                EXPECT_EQ(sum.edges()[e].to, plain_sum.edges()[e].to);
            }
        }
    }
}

} // namespace
} // namespace proxima::planar_sum_test
