// Minkowski sums against CGAL's convex hull of all pair sums, with exact predicates.
#include "polytopes.h"
#include "proxima/minkowski_sum.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>
#include <gtest/gtest.h>

#include <array>
#include <set>

namespace proxima::minkowski_cgal_test {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

TEST(MinkowskiSumByCgal, HasTheSameCorners)
{
    int bodies = 0;
    for (unsigned seed = 0; seed < 120; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const bool is_round = seed % 2 == 0;
        const auto operand = [&] {
            return test::hull_of(is_round ? test::round_points(random, 40, 1e5)
                                          : test::nasty_points(random));
        };
        const ConvexPolyhedron a = operand();
        const ConvexPolyhedron b = operand();
        const auto sum = *minkowski_sum(a, b);
        if (sum.dimension() < 3) continue;
        ++bodies;
        std::vector<Kernel::Point_3> points; // whole numbers: the sums are exact
        for (const Vec3& p : a.points()) {
            for (const Vec3& q : b.points())
                points.emplace_back(p.x() + q.x(), p.y() + q.y(), p.z() + q.z());
        }
        CGAL::Surface_mesh<Kernel::Point_3> hull;
        CGAL::convex_hull_3(points.begin(), points.end(), hull);
        // CGAL may keep corners that lie on an edge or a facet: each hull holds the other's.
        std::set<std::array<double, 3>> theirs;
        for (const auto v : hull.vertices()) {
            const auto& p = hull.point(v);
            theirs.insert({p.x(), p.y(), p.z()});
            EXPECT_TRUE(contains(sum, {p.x(), p.y(), p.z()}));
        }
        for (std::uint32_t v = 0; v < sum.vertex_count(); ++v) {
            const Vec3 p = sum.position(v);
            EXPECT_EQ(theirs.count({p.x(), p.y(), p.z()}), 1U);
        }
        if (is_round) {
            EXPECT_EQ(theirs.size(), sum.vertex_count());
        }
        if (HasFailure()) break;
    }
    EXPECT_GT(bodies, 80);
}

} // namespace
} // namespace proxima::minkowski_cgal_test
