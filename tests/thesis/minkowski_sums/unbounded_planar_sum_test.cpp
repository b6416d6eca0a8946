// Planar sums of unbounded polygons against every candidate normal over all pairs, in 128-bit whole
// numbers.
#include "thesis/minkowski_sums/whole_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace proxima::unbounded_planar_sum_test {
namespace {

using namespace testing;

/// An unbounded edge as brute force finds it: ends that are at infinity have no point.
struct PlainEdge {
    Whole direction;
    Whole from;
    Whole to;
    bool from_infinity = false;
    bool to_infinity = false;
};

struct PlainOperand {
    std::vector<Whole> points;
    std::vector<Whole> rays;
};

/// Every edge of either operand's hull and every ray, both ways, as a direction; those along which
/// nothing obstructs, with the farthest points of all pairs.
std::vector<PlainEdge> brute_force_edges(const PlainOperand& a, const PlainOperand& b)
{
    std::vector<Whole> points;
    for (const Whole& p : a.points)
        for (const Whole& q : b.points) points.push_back(p + q);
    std::vector<Whole> rays = a.rays;
    rays.insert(rays.end(), b.rays.begin(), b.rays.end());
    std::vector<Whole> directions;
    for (const Whole& p : points)
        for (const Whole& q : points) directions.push_back(q - p);
    for (const Whole& ray : rays) {
        directions.push_back(ray);
        directions.push_back({-ray[0], -ray[1]});
    }
    std::vector<PlainEdge> edges;
    for (const Whole& d : directions) {
        if (d == Whole{0, 0}) continue;
        const auto along = [&](const Whole& v) { return dot(d, v); };
        const auto out = [&](const Whole& v) { return -cross(d, v); };
        if (std::ranges::any_of(rays, [&](const Whole& r) { return out(r) > 0; })) continue;
        const bool is_known = std::ranges::any_of(edges, [&](const PlainEdge& edge) {
            return cross(edge.direction, d) == 0 && along(edge.direction) > 0;
        });
        if (is_known) continue;
        PlainEdge edge = {d, points[0], points[0]};
        for (const Whole& p : points) {
            const Wide beyond = out(p - edge.to);
            if (beyond > 0) edge.from = edge.to = p;
            if (beyond == 0 && along(p - edge.to) > 0) edge.to = p;
            if (beyond == 0 && along(p - edge.from) < 0) edge.from = p;
        }
        for (const Whole& r : rays) {
            edge.to_infinity = edge.to_infinity || (out(r) == 0 && along(r) > 0);
            edge.from_infinity = edge.from_infinity || (out(r) == 0 && along(r) < 0);
        }
        if (edge.from == edge.to && !edge.from_infinity && !edge.to_infinity) continue;
        edges.push_back(edge);
    }
    return edges;
}

Points random_rays(std::mt19937_64& random)
{
    std::uniform_int_distribution<int> coordinate(-3, 3);
    std::uniform_int_distribution<int> count(1, 3);
    while (true) {
        Points rays(static_cast<std::size_t>(count(random)));
        for (Vec2& ray : rays) {
            ray.x() = coordinate(random);
            ray.y() = coordinate(random);
        }
        if (convex_polygon(Points{Vec2::Zero()}, rays)) return rays;
    }
}

PlainOperand plain(const Points& points, const Points& rays)
{
    PlainOperand operand;
    for (const Vec2& point : points) operand.points.push_back(whole(point));
    for (const Vec2& ray : rays) operand.rays.push_back(whole(ray));
    return operand;
}

Points small_points(std::mt19937_64& random)
{
    std::uniform_int_distribution<int> coordinate(-4, 4);
    Points points(static_cast<std::size_t>(std::uniform_int_distribution<int>(1, 5)(random)));
    for (Vec2& point : points) {
        point.x() = coordinate(random);
        point.y() = coordinate(random);
    }
    return points;
}

void expect_same_edges(const PlanarSum& sum, const PlanarSum& other)
{
    ASSERT_EQ(sum.edges().size(), other.edges().size());
    for (std::size_t e = 0; e < sum.edges().size(); ++e) {
        const PlanarEdge& one = sum.edges()[e];
        const PlanarEdge& two = other.edges()[e];
        EXPECT_EQ(one.normal, two.normal);
        EXPECT_EQ(one.offset, two.offset);
        EXPECT_EQ(one.support, two.support);
        EXPECT_EQ(one.from, two.from);
        EXPECT_EQ(one.to, two.to);
        EXPECT_EQ(one.from_infinity, two.from_infinity);
        EXPECT_EQ(one.to_infinity, two.to_infinity);
    }
}

TEST(UnboundedPlanarSum, AgreesWithBruteForceWhereverItIsCut)
{
    int whole_planes = 0;
    for (unsigned seed = 0; seed < 3000; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        const Points points_a = small_points(random);
        const Points rays_a = random_rays(random);
        const Points points_b = small_points(random);
        const Points rays_b = seed % 3 == 0 ? random_rays(random) : Points();
        const ConvexPolygon a = polygon_of(points_a, rays_a);
        const ConvexPolygon b = polygon_of(points_b, rays_b);
        const PlanarSum sum = sum_of(a, b);
        for (const double cut : {1e-3, 100.0}) expect_same_edges(sum, sum_of(a, b, cut));

        const auto expected = brute_force_edges(plain(points_a, rays_a), plain(points_b, rays_b));
        ASSERT_EQ(sum.edges().size(), expected.size());
        whole_planes += sum.is_whole_plane() ? 1 : 0;
        for (const PlanarEdge& edge : sum.edges()) {
            const auto is_same = [&](const PlainEdge& plain_edge) {
                const Vec2 normal(static_cast<double>(plain_edge.direction[1]),
                                  -static_cast<double>(plain_edge.direction[0]));
                return (normal.normalized() - edge.normal).norm() < 1e-12;
            };
            const auto found = std::ranges::find_if(expected, is_same);
            ASSERT_NE(found, expected.end());
            EXPECT_EQ(edge.from_infinity, found->from_infinity);
            EXPECT_EQ(edge.to_infinity, found->to_infinity);
            if (!edge.from_infinity) {
                EXPECT_EQ(exact_point(sum, edge.from), found->from);
            }
            if (!edge.to_infinity) {
                EXPECT_EQ(exact_point(sum, edge.to), found->to);
            }
            EXPECT_EQ(cross(found->direction, exact_point(sum, edge.support) - found->to), 0);
        }
        for (std::size_t e = 1; e < sum.edges().size(); ++e) {
            if (!sum.edges()[e].from_infinity) {
                EXPECT_EQ(sum.edges()[e - 1].to, sum.edges()[e].from);
            }
        }
    }
    EXPECT_GT(whole_planes, 100);
}

/// Figure 4.7: the region of a corner, cut, grown by a square; three of seven edges obstruct.
TEST(UnboundedPlanarSum, FlagsTheEdgesThatObstructARegion)
{
    const ConvexPolygon region = polygon_of({{0, 0}}, {{1, 2}, {-2, 1}});
    const ConvexPolygon square = polygon_of({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}});
    for (const double cut : {1e-3, 1.0, 100.0}) {
        const PlanarSum sum = sum_of(region, square, cut);
        ASSERT_EQ(sum.lines().size(), 7U);
        ASSERT_EQ(sum.edges().size(), 3U); // two of the rays, the lower side of the square
        int obstructing = 0;
        for (const PushedLine& line : sum.lines()) {
            const bool is_positive =
                line.normal.dot(Vec2(1, 2)) > 1e-12 || line.normal.dot(Vec2(-2, 1)) > 1e-12;
            EXPECT_EQ(line.edge < 0, is_positive);
            EXPECT_TRUE(line.spans_edge);
            obstructing += line.edge < 0 ? 1 : 0;
        }
        EXPECT_EQ(obstructing, 4); // three sides of the square, the cut
        EXPECT_TRUE(sum.edges().front().from_infinity);
        EXPECT_TRUE(sum.edges().back().to_infinity);
        EXPECT_EQ(sum.edges()[1].normal, Vec2(0, -1));
    }
}

} // namespace
} // namespace proxima::unbounded_planar_sum_test
