#include "proxima/minkowski_sum.h"

#include "polytopes.h"
#include "proxima/convex_polyhedron.h"

#include <gtest/gtest.h>

#include <set>

namespace proxima::sum_queries_test {
namespace {

using test::Points;

/// In the hull of all pair sums, by exact orientation: for whole numbers and scales.
bool in_hull_of_pairs(const ConvexPolyhedron& a, const ConvexPolyhedron& b, double scale,
                      const Vec3& x)
{
    Points sums;
    for (const Vec3& p : a.points()) {
        for (const Vec3& q : b.points()) sums.emplace_back(p + scale * q);
    }
    Points with = sums;
    const ConvexPolyhedron hull = test::hull_of(sums);
    // x is in it exactly if it makes no new corner.
    with.push_back(x);
    const auto has_corner = [&](const ConvexPolyhedron& of) {
        return std::ranges::any_of(of.points(), [&](const Vec3& p) { return p == x; });
    };
    return has_corner(hull) || !has_corner(test::hull_of(with));
}

TEST(SumQueries, ContainsIsExactOnNastySumsOfAllDimensions)
{
    int inside = 0;
    for (unsigned seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const auto a = test::hull_of(test::nasty_points(random));
        const auto b = test::hull_of(test::nasty_points(random));
        const double scale = seed % 2 == 0 ? 1 : 0.25 * (1 + static_cast<double>(random() % 9));
        const auto sum = minkowski_sum(a, b)->scaled(scale);
        Points tests;
        for (std::uint32_t v = 0; v < sum.vertex_count(); ++v) tests.push_back(sum.position(v));
        const std::size_t corners = tests.size();
        for (int i = 0; i < 8; ++i) { // centres of pairs: on edges, facets, inside; and beside
            const Vec3 p = tests[random() % corners];
            const Vec3 q = tests[random() % corners];
            tests.emplace_back(0.5 * p + 0.5 * q);
            tests.emplace_back(p + 0.25 * test::whole_points(random, 1, 2)[0]);
            tests.emplace_back(p + 0x1p-40 * test::whole_points(random, 1, 1)[0]);
        }
        for (const Vec3& x : tests) {
            const bool expected = in_hull_of_pairs(a, b, scale, x);
            EXPECT_EQ(contains(sum, x), expected) << x.transpose();
            inside += expected ? 1 : 0;
        }
        if (HasFailure()) break;
    }
    EXPECT_GT(inside, 1000);
}

TEST(SumQueries, APointIsNoOtherPointAlongAnyAxis)
{
    const Vec3 at(5, -3, 2);
    const auto sum = *minkowski_sum(test::hull_of({at}), test::hull_of({{0, 0, 0}}));
    ASSERT_EQ(sum.dimension(), 0);
    EXPECT_TRUE(contains(sum, at));
    for (int axis = 0; axis < 3; ++axis) {
        for (const double by : {1.0, -1.0, 0x1p-40})
            EXPECT_FALSE(contains(sum, at + by * Vec3::Unit(axis))) << axis << ' ' << by;
    }
}

TEST(SumQueries, FlatSumsAcrossEachAxisHoldTheirPoints)
{
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 u = Vec3::Unit((axis + 1) % 3);
        const Vec3 v = Vec3::Unit((axis + 2) % 3);
        const Vec3 at = 3 * Vec3::Unit(axis) + Vec3(7, -5, 2);
        const auto sum = *minkowski_sum(test::hull_of({at, at + u, at + v, at + u + v}),
                                        test::hull_of({u, 2 * v}));
        ASSERT_EQ(sum.dimension(), 2) << axis;
        for (double x = -1; x <= 3; x += 0.5) {
            for (double y = -1; y <= 4; y += 0.5) {
                // The square moved along the segment from (1, 0) to (0, 2).
                bool holds = false;
                for (double t = 0; t <= 1; t += 0x1p-6)
                    holds = holds || (x >= 1 - t && x <= 2 - t && y >= 2 * t && y <= 2 * t + 1);
                const Vec3 p = at + x * u + y * v;
                EXPECT_EQ(contains(sum, p), holds) << axis << ' ' << x << ' ' << y;
                EXPECT_FALSE(contains(sum, p + 0x1p-40 * Vec3::Unit(axis)));
            }
        }
    }
}

TEST(SumQueries, OnTheSurfaceTheDirectionIsThatOfAFacet)
{
    // Touching from outside, where the way from the surface to the point has no direction.
    const auto sum =
        *minkowski_sum(test::hull_of(test::cube_points(1)), test::hull_of(test::cube_points(1)));
    for (const Vec3& place :
         {Vec3(2, 0.5, 0.25), Vec3(0.5, -2, 1), Vec3(2, 2, 0), Vec3(-2, 2, 2)}) {
        const SurfacePoint found = signed_distance(sum, place);
        EXPECT_EQ(found.distance, 0);
        ASSERT_LT(found.facet, sum.facet_count());
        EXPECT_EQ(found.direction, sum.half_space(found.facet).normal);
        EXPECT_EQ(found.direction.dot(place), 2) << place.transpose();
    }
    // A flat sum holds the point: the direction is across it.
    const auto flat = *minkowski_sum(test::hull_of({{0, 0, 1}, {4, 0, 1}, {0, 4, 1}}),
                                     test::hull_of({{0, 0, 0}}));
    ASSERT_EQ(flat.dimension(), 2);
    const SurfacePoint held = signed_distance(flat, {1, 1, 1});
    EXPECT_EQ(held.distance, 0);
    EXPECT_EQ(std::abs(held.direction.z()), 1);
}

TEST(SumQueries, SignedDistanceIsThatOfTheNearestPoint)
{
    for (unsigned seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const auto a = test::hull_of(test::nasty_points(random));
        const auto b = test::hull_of(test::nasty_points(random));
        const auto sum = *minkowski_sum(a, b);
        std::uniform_real_distribution<double> coordinate(-8, 8);
        for (int i = 0; i < 10; ++i) {
            const Vec3 x{coordinate(random), coordinate(random), coordinate(random)};
            const SurfacePoint found = signed_distance(sum, x);
            const double reach = 1e-9 * (1 + x.norm() + found.nearest.norm());
            EXPECT_NEAR((x - found.nearest).norm(), std::abs(found.distance), reach);
            if (sum.dimension() == 3) {
                EXPECT_EQ(found.distance <= 0, contains(sum, x));
            }
            if (found.distance >= 0) {
                // The plane through the nearest place across the way there separates: no corner is
                // nearer along it. That proves it the nearest of a convex set.
                for (std::uint32_t v = 0; v < sum.vertex_count(); ++v)
                    EXPECT_LE(found.direction.dot(sum.position(v) - found.nearest), reach);
            } else {
                // A ball of that size fits: it keeps to this side of every plane.
                for (std::uint32_t f = 0; f < sum.facet_count(); ++f) {
                    const HalfSpace plane = sum.half_space(f);
                    EXPECT_LE(plane.normal.dot(x) - found.distance, plane.offset + reach);
                }
                EXPECT_FALSE(
                    contains(sum, x + (1e-9 - found.distance) * found.direction * 1.0000001));
            }
        }
        if (HasFailure()) break;
    }
}

TEST(SumQueries, DistancesScaleExactly)
{
    for (const double size : {0x1p-660, 0x1p-100, 0x1p200, 0x1p280}) {
        const auto cube = test::hull_of(test::cube_points(size));
        const auto sum = *minkowski_sum(cube, test::hull_of({{0, 0, 0}}));
        EXPECT_DOUBLE_EQ(signed_distance(sum, size * Vec3(3, 3, 0)).distance / size, std::sqrt(8));
        EXPECT_DOUBLE_EQ(signed_distance(sum, size * Vec3(3, 3, 3)).distance / size, std::sqrt(12));
        EXPECT_DOUBLE_EQ(signed_distance(sum, size * Vec3(0.5, 0, 0)).distance / size, -0.5);
    }
}

TEST(SumQueries, DistancesAreThoseOfFiniteCornersWhereOthersOverflow)
{
    // Of half sizes 1e310, which is no double, 1e300 and 1e300.
    const auto box = polyhedron_of_box({{-1e10, -1, -1}, {1e10, 1, 1}}).value();
    const auto sum = minkowski_sum(test::hull_of({{0, 0, 0}}), box)->scaled(1e300);
    const SurfacePoint center = signed_distance(sum, Vec3::Zero());
    EXPECT_DOUBLE_EQ(center.distance, -1e300);
    EXPECT_EQ(center.direction.x(), 0);
    const SurfacePoint higher = signed_distance(sum, {0, 0.25e300, 0.5e300});
    EXPECT_DOUBLE_EQ(higher.distance, -0.5e300);
    EXPECT_EQ(higher.direction, Vec3(0, 0, 1));
}

/// Corners are in the sum exactly, whatever their heights above its planes are rounded to.
TEST(SumQueries, NoCornerIsOutside)
{
    for (unsigned seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> coordinate(-1, 1);
        Points points(40);
        for (Vec3& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
        const auto sum = *minkowski_sum(test::hull_of(points), test::hull_of({{0, 0, 0}}));
        for (std::uint32_t v = 0; v < sum.vertex_count(); ++v) {
            const double distance = signed_distance(sum, sum.position(v)).distance;
            EXPECT_LE(distance, 0);
            EXPECT_GE(distance, -1e-14);
        }
    }
}

TEST(SumQueries, NothingEndsTheWayAlongARay)
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (unsigned seed = 0; seed < 100; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> coordinate(0.9, 1.1);
        Points rays(3);
        for (Vec3& r : rays) r = {coordinate(random), coordinate(random), coordinate(random)};
        const auto cone = test::hull_of({{0, 0, 0}}, rays);
        const auto sum = *minkowski_sum(cone, test::hull_of({{0, 0, 0}}));
        const auto rounded = *minkowski_sum(cone, test::hull_of(test::cube_points(1)));
        for (const Vec3& r : rays) {
            EXPECT_EQ(directional_depth(sum, r, r.normalized()), infinity);
            EXPECT_EQ(directional_depth(rounded, r, r.normalized()), infinity);
            // Back to the tip, which is in all planes.
            EXPECT_NEAR(directional_depth(sum, r, -r.normalized()).value(), r.norm(), 1e-12);
        }
    }
}

TEST(SumQueries, UnboundedSumsHaveDistancesToo)
{
    // A quadrant of columns: x, y >= 0, grown by a cube.
    const auto corner = test::hull_of({{0, 0, 0}}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    const auto cube = test::hull_of(test::cube_points(1));
    const auto sum = *minkowski_sum(corner, cube);
    EXPECT_EQ(sum.facet_count(), 3U);
    EXPECT_DOUBLE_EQ(signed_distance(sum, {-1, 5, 5}).distance, 0);
    EXPECT_DOUBLE_EQ(signed_distance(sum, {-4, -5, 5}).distance, 5);
    EXPECT_DOUBLE_EQ(signed_distance(sum, {1, 5, 7}).distance, -2);
    EXPECT_EQ(directional_depth(sum, {1, 1, 1}, Vec3(0, 0, 1)),
              std::numeric_limits<double>::infinity());
    EXPECT_DOUBLE_EQ(directional_depth(sum, {1, 1, 1}, Vec3(0, 0, -1)).value(), 2);
    EXPECT_FALSE(directional_depth(sum, {-3, 1, 1}, Vec3(0, 0, -1)));
    EXPECT_TRUE(contains(sum, {1e80, 0, 0}));

    // Opposite corners make all of space.
    const auto opposite = test::hull_of({{0, 0, 0}}, {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
    const auto everything = *minkowski_sum(corner, opposite);
    EXPECT_TRUE(everything.is_all_of_space());
    EXPECT_TRUE(contains(everything, {7, -9, 11}));
    EXPECT_FALSE(separation(corner, corner));
    EXPECT_DOUBLE_EQ(separation(corner, opposite)->distance, 0);
    // Two wedges that share a wall's direction make a half-space.
    const auto up = test::hull_of({{0, 0, 0}}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    const auto down = test::hull_of({{0, 0, 0}}, {{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}});
    const auto half = *minkowski_sum(up, down);
    EXPECT_TRUE(half.holds_line());
    ASSERT_EQ(half.facet_count(), 1U);
    EXPECT_EQ(half.half_space(0).normal, Vec3(0, 0, -1));
    EXPECT_TRUE(contains(half, {-5, 9, 0}));
    EXPECT_FALSE(contains(half, {-5, 9, -1e-300}));
}

TEST(SumQueries, FlatUnboundedSumsEndInTwoRays)
{
    // A quadrant of a plane and a segment across it: two corners, and two rays in a row. Away from
    // the origin, lest lines through the origin were as good.
    const Vec3 at(7, -3, 2);
    const auto quadrant = test::hull_of({at}, {{1, 0, 0}, {0, 1, 0}});
    const auto across = test::hull_of({{1, -1, 0}, {-1, 1, 0}});
    const auto sum = *minkowski_sum(quadrant, across);
    ASSERT_EQ(sum.dimension(), 2);
    const auto distance_to = [](const Vec3& from, const Vec3& along, double most, const Vec3& p) {
        const double t = std::clamp(along.dot(p - from) / along.squaredNorm(), 0.0, most);
        return (p - from - t * along).norm();
    };
    constexpr double endless = 1e9;
    for (const double z : {0.0, 0.25}) {
        for (double y = -4; y <= 4; y += 0.5) {
            for (double x = -4; x <= 4; x += 0.5) {
                SCOPED_TRACE(::testing::Message() << x << ' ' << y << ' ' << z);
                // The segment has one point (t, -t) that is below and to the left.
                const bool over = std::max(-1.0, -y) <= std::min(1.0, x);
                const Vec3 p(x, y, z);
                EXPECT_EQ(contains(sum, at + p), over && z == 0);
                const double to_border = std::min({distance_to({1, -1, 0}, {1, 0, 0}, endless, p),
                                                   distance_to({-1, 1, 0}, {0, 1, 0}, endless, p),
                                                   distance_to({1, -1, 0}, {-2, 2, 0}, 1, p)});
                EXPECT_NEAR(signed_distance(sum, at + p).distance, over ? z : to_border, 1e-14);
            }
        }
    }
}

TEST(SumQueries, SeparationPullsBodiesApart)
{
    for (unsigned seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const Points points_b = test::nasty_points(random);
        const auto a = test::hull_of(test::nasty_points(random));
        const auto b = test::hull_of(points_b);
        const auto found = separation(a, b);
        ASSERT_TRUE(found);
        if (found->distance == 0 && a.dimension() + b.dimension() < 3) continue;
        EXPECT_NEAR(found->direction.norm(), 1, 1e-12);
        const auto moved_by = [&](double distance) {
            Points moved = points_b;
            for (Vec3& p : moved) p += distance * found->direction;
            return separation(a, test::hull_of(moved))->distance;
        };
        const double size = 1e-9 * (1 + std::abs(found->distance));
        EXPECT_NEAR(moved_by(-found->distance), 0, size);
        EXPECT_GT(moved_by(1 - found->distance), 0.5);
        if (found->distance < -size) { // not by rounding alone
            EXPECT_LT(moved_by(-0.5 * found->distance), 0);
        }
    }
}

TEST(MinkowskiSum, ScalingKeepsTheTopology)
{
    for (unsigned seed = 0; seed < 100; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const Points points_b = test::nasty_points(random);
        const auto a = test::hull_of(test::nasty_points(random));
        const auto sum = *minkowski_sum(a, test::hull_of(points_b));
        for (const double lambda : {0.5, 3.0}) {
            Points larger = points_b;
            for (Vec3& p : larger) p *= lambda;
            const auto built = *minkowski_sum(a, test::hull_of(larger));
            const auto scaled = sum.scaled(lambda);
            ASSERT_EQ(built.vertex_count(), scaled.vertex_count());
            ASSERT_EQ(built.facet_count(), scaled.facet_count());
            // The order depends on the hulls' inner ways: compare as sets of sets.
            const auto described = [](const MinkowskiSum& of) {
                std::set<std::set<std::array<double, 3>>> facets;
                for (std::uint32_t f = 0; f < of.facet_count(); ++f) {
                    std::set<std::array<double, 3>> corners;
                    for (const std::uint32_t v : of.facet_loop(f)) {
                        const Vec3 p = of.position(v);
                        corners.insert({p.x(), p.y(), p.z()});
                        EXPECT_NEAR(of.half_space(f).normal.dot(p), of.half_space(f).offset,
                                    1e-12 * (1 + p.norm()));
                    }
                    facets.insert(corners);
                }
                return facets;
            };
            EXPECT_EQ(described(built), described(scaled));
        }
    }
}

} // namespace
} // namespace proxima::sum_queries_test
