// Hulls against a brute force over all triples of whole points, in exact arithmetic.
#include "proxima/convex_polyhedron.h"

#include "geometry/exact_predicates.h"
#include "minkowski/quickhull.h"
#include "polytopes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace proxima::convex_hull_test {
namespace {

using test::Points;

/// The sets of points in the supporting planes: every facet as the brute force sees it.
std::set<std::vector<std::size_t>> brute_force_facets(const Points& points)
{
    std::set<std::vector<std::size_t>> facets;
    const std::size_t n = points.size();
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 1; j < n; ++j) {
            for (std::size_t k = j + 1; k < n; ++k) {
                if (is_degenerate({{points[i], points[j], points[k]}})) continue;
                std::vector<std::size_t> in_plane;
                bool above = false;
                bool below = false;
                for (std::size_t m = 0; m < n; ++m) {
                    const int side = orient3d(points[i], points[j], points[k], points[m]);
                    above = above || side > 0;
                    below = below || side < 0;
                    if (side == 0) in_plane.push_back(m);
                }
                if (above != below) facets.insert(in_plane);
            }
        }
    }
    return facets;
}

void expect_hull(const Points& points, const ConvexPolyhedron& hull)
{
    // Distinct points only: the hull has each corner once.
    Points distinct = points;
    std::ranges::sort(distinct, [](const Vec3& p, const Vec3& q) {
        return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    });
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    const auto expected = brute_force_facets(distinct);
    ASSERT_EQ(hull.facet_count(), expected.size());
    for (std::uint32_t f = 0; f < hull.facet_count(); ++f) {
        const auto loop = hull.facet_loop(f);
        const auto corner = [&](std::size_t i) { return hull.vertex(loop[i % loop.size()]); };
        std::vector<std::size_t> in_plane;
        for (std::size_t m = 0; m < distinct.size(); ++m) {
            const int side = hull.normal_sign(f, {corner(0), distinct[m]});
            EXPECT_LE(side, 0);
            if (side == 0) in_plane.push_back(m);
        }
        EXPECT_EQ(expected.count(in_plane), 1U);
        // The loop turns left about the normal at each corner: convex, and no corner in between.
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec3 turn =
                (corner(i + 1) - corner(i)).cross(Vec3(corner(i + 2) - corner(i + 1)));
            EXPECT_GT(turn.dot(hull.scaled_normal(f)), 0);
        }
    }
    for (const PolyhedronEdge& edge : hull.edges()) {
        EXPECT_LT(edge.from, edge.to);
        EXPECT_NE(edge.left, no_facet);
        EXPECT_NE(edge.right, no_facet);
    }
    EXPECT_EQ(static_cast<int>(hull.vertex_count()) - static_cast<int>(hull.edges().size()) +
                  static_cast<int>(hull.facet_count()),
              2);
}

TEST(ConvexHull, EqualsBruteForceOnNastyPoints)
{
    std::map<int, int> dimensions;
    for (unsigned seed = 0; seed < 800; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const Points points = test::nasty_points(random);
        const ConvexPolyhedron hull = test::hull_of(points);
        ++dimensions[hull.dimension()];
        if (hull.dimension() == 3) {
            expect_hull(points, hull);
        } else {
            for (const Vec3& p : points) {
                for (const Vec3& q : points) {
                    for (const Vec3& r : points)
                        ASSERT_EQ(orient3d(points[0], p, q, r), 0) << "not flat";
                }
            }
        }
        // A hull's corners are the hull of themselves, each an input point.
        const ConvexPolyhedron again = test::hull_of({hull.points().begin(), hull.points().end()});
        EXPECT_EQ(again.vertex_count(), hull.vertex_count());
        EXPECT_EQ(again.facet_count(), hull.facet_count());
        if (HasFailure()) break;
    }
    for (int dimension = 0; dimension <= 3; ++dimension) EXPECT_GT(dimensions[dimension], 10);
}

TEST(ConvexHull, PolygonsHaveExtremeCornersInOrder)
{
    for (unsigned seed = 0; seed < 1000; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        Points points = test::whole_points(random, 3 + static_cast<int>(random() % 12), 3);
        for (Vec3& p : points) p.z() = p.x() - 2 * p.y(); // an exact plane, not parallel to an axis
        const ConvexPolyhedron hull = test::hull_of(points);
        if (hull.dimension() < 2) continue;
        ASSERT_EQ(hull.dimension(), 2);
        ASSERT_EQ(hull.facet_count(), 2U);
        const auto loop = hull.facet_loop(0);
        EXPECT_EQ(loop.size(), hull.vertex_count());
        EXPECT_EQ(hull.edges().size(), hull.vertex_count());
        const Vec3 normal = hull.scaled_normal(0);
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec3& p = hull.vertex(loop[i]);
            const Vec3& q = hull.vertex(loop[(i + 1) % loop.size()]);
            const Vec3& r = hull.vertex(loop[(i + 2) % loop.size()]);
            EXPECT_GT((q - p).cross(r - q).dot(normal), 0);
            for (const Vec3& x : points) EXPECT_GE((q - p).cross(x - p).dot(normal), 0);
        }
    }
}

TEST(ConvexHull, ContainsRandomTinyAndHugePoints)
{
    for (const double scale : {1e-200, 1e-30, 1.0, 1e30, 1e90}) {
        for (unsigned seed = 0; seed < 6; ++seed) {
            SCOPED_TRACE(seed);
            std::mt19937 random(seed);
            std::uniform_real_distribution<double> coordinate(-1, 1);
            Points points(200);
            for (Vec3& p : points) {
                for (double& c : p) c = scale * coordinate(random);
            }
            const ConvexPolyhedron hull = test::hull_of(points);
            ASSERT_EQ(hull.dimension(), 3);
            for (std::uint32_t f = 0; f < hull.facet_count(); ++f) {
                const auto loop = hull.facet_loop(f);
                for (const Vec3& p : points) {
                    EXPECT_LE(orient3d(hull.vertex(loop[0]), hull.vertex(loop[1]),
                                       hull.vertex(loop[2]), p),
                              0);
                }
                EXPECT_NEAR(hull.half_space(f).normal.norm(), 1, 1e-12);
            }
            EXPECT_EQ(hull.vertex_count() + hull.facet_count(), hull.edges().size() + 2);
        }
    }
}

TEST(ConvexHull, UnboundedHullsHaveTheirRaysInLoops)
{
    // The wedge of an edge between two faces: two strips and two wedge-shaped ends.
    const auto wedge = test::hull_of({{0, 0, 0}, {1, 0, 0}}, {{0, 0, 1}, {0, -1, 0}});
    EXPECT_EQ(wedge.dimension(), 3);
    EXPECT_EQ(wedge.points().size(), 2U);
    EXPECT_EQ(wedge.rays().size(), 2U);
    EXPECT_EQ(wedge.facet_count(), 4U);
    EXPECT_EQ(wedge.edges().size(), 5U);
    EXPECT_FALSE(wedge.is_bounded());
    EXPECT_EQ(wedge.support({0, 0, 1}).value, std::numeric_limits<double>::infinity());
    EXPECT_EQ(wedge.support({1, 0, -1}).value, 1);

    // A quadrant of the plane, a strip, a half-line.
    EXPECT_EQ(test::hull_of({{0, 0, 0}}, {{1, 0, 0}, {0, 1, 0}, {1, 1, 0}}).rays().size(), 2U);
    const auto strip = test::hull_of({{0, 0, 0}, {0, 2, 0}, {3, 1, 0}}, {{1, 0, 0}});
    EXPECT_EQ(strip.dimension(), 2);
    EXPECT_EQ(strip.points().size(), 2U);
    const auto half_line = test::hull_of({{0, 0, 0}, {5, 0, 0}}, {{-2, 0, 0}});
    EXPECT_EQ(half_line.dimension(), 1);
    EXPECT_EQ(half_line.points()[0], Vec3(5, 0, 0));
}

TEST(ConvexHull, SupportNamesAPointThatReachesFarthest)
{
    const auto cube = test::hull_of(test::cube_points(1));
    for (int i = 0; i < 125; ++i) {
        const Vec3 n(i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2);
        const PolyhedronSupport found = cube.support(n);
        EXPECT_EQ(found.value, n.cwiseAbs().sum()) << n.transpose();
        EXPECT_EQ(n.dot(cube.vertex(found.vertex)), found.value) << n.transpose();
    }
}

/// A cone's tip is in all its planes, and rays slide along them but for rounding.
TEST(ConvexHull, NoRayReachesBeyondItsOwnFacets)
{
    const Vec3 tip(3, -2, 1);
    for (unsigned seed = 0; seed < 100; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> coordinate(0.5, 1.5);
        Points rays(4);
        for (Vec3& r : rays) r = {coordinate(random), coordinate(random), coordinate(random)};
        const auto cone = test::hull_of({tip}, rays);
        ASSERT_GE(cone.facet_count(), 3U);
        for (std::uint32_t f = 0; f < cone.facet_count(); ++f) {
            const Vec3 normal = cone.half_space(f).normal;
            EXPECT_DOUBLE_EQ(cone.support(normal).value, normal.dot(tip));
            // Tilted toward a ray, by little but not by rounding.
            EXPECT_EQ(cone.support(normal + 1e-9 * rays[0]).value,
                      std::numeric_limits<double>::infinity());
        }
    }
}

/// A ray that waits is held against some 25 faces, whatever the order and the lengths.
TEST(ConvexHull, RaysInOrderRoundAConeTakeNoMoreTrialsThanOthers)
{
    std::mt19937 random(1);
    for (const bool in_order : {true, false}) {
        for (const double longest : {1.0, 1e6}) {
            Points vertices = {{0, 0, 0}};
            const std::size_t rays = 8000;
            for (std::size_t i = 0; i < rays; ++i) {
                const double x = static_cast<double>(i) / rays;
                const double length = std::pow(longest, x);
                vertices.emplace_back(length * Vec3(x, x * x, 1));
            }
            if (!in_order) std::shuffle(vertices.begin() + 1, vertices.end(), random);
            const detail::HullVertices with_rays = {vertices, 1};
            std::uint64_t trials = 0;
            const auto triangles =
                detail::quickhull(with_rays, detail::affine_span(with_rays), nullptr, &trials);
            ASSERT_TRUE(triangles);
            EXPECT_EQ(triangles->size(), 2 * rays - 2);
            EXPECT_LT(trials, 100 * rays);
        }
    }
}

TEST(ConvexHull, RefusesBadInput)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto code = [](const auto& result) {
        return result ? std::optional<ErrorCode>() : result.error().code;
    };
    EXPECT_EQ(code(convex_hull({})), ErrorCode::invalid_argument);
    EXPECT_EQ(code(convex_hull(Points{{0, 0, nan}})), ErrorCode::invalid_argument);
    EXPECT_EQ(code(convex_hull(Points{{0, 0, 1e300}})), ErrorCode::limit_exceeded);
    EXPECT_EQ(code(convex_hull(Points{{0, 0, 0}}, Points{{0, 0, 0}})), ErrorCode::invalid_argument);
    // Rays that add up to nothing: opposite ones, three in a plane, four in space.
    EXPECT_EQ(code(convex_hull(Points{{0, 0, 0}}, Points{{1, 0, 0}, {-2, 0, 0}})),
              ErrorCode::invalid_argument);
    EXPECT_EQ(code(convex_hull(Points{{0, 0, 0}}, Points{{1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}})),
              ErrorCode::invalid_argument);
    EXPECT_EQ(code(convex_hull(Points{{0, 0, 0}},
                               Points{{1, 0, 0}, {-1, 1, 0}, {-1, -1, 1}, {0, 0, -1}})),
              ErrorCode::invalid_argument);
    Progress progress;
    progress.cancel();
    std::mt19937 random(1);
    EXPECT_EQ(code(convex_hull(test::round_points(random, 2000, 1e6), {}, {.progress = &progress})),
              ErrorCode::cancelled);
}

} // namespace
} // namespace proxima::convex_hull_test
