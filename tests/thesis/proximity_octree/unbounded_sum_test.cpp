#include "thesis/proximity_octree/unbounded_sum.h"

#include "code_of.h"
#include "minkowski/polytopes.h"
#include "proxima/sample_meshes.h"
#include "thesis/proximity_octree/voronoi_region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace proxima::unbounded_sum_test {
namespace {

using test::Points;

/// Sums by rays and by cutting have the same half-spaces for every length of the cut.
TEST(UnboundedSum, EqualsCuttingForAnyLength)
{
    const TriangleMesh sphere = make_sphere(8, 9);
    for (unsigned seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const auto pick = static_cast<std::uint32_t>(random() % sphere.triangle_count());
        const Triangle t = sphere.triangle(TriangleId{pick});
        const Vec3 n = scaled_normal(t);
        Result<ConvexPolyhedron> region = voronoi_region_of_face(t);
        if (seed % 3 == 1) {
            region = voronoi_region_of_edge(t[0], t[1], n, Vec3(n + 0.1 * Vec3(1, -1, 0.5)));
        }
        if (seed % 3 == 2) {
            const Points normals = {n, n + Vec3(0.1, 0, 0.01), n + Vec3(0.1, 0.1, 0),
                                    n + Vec3(0, 0.1, 0)};
            region = voronoi_region_of_vertex(t[0], normals);
        }
        ASSERT_TRUE(region) << describe(region.error());
        const auto cube = test::hull_of(test::cube_points(0.125));
        const auto by_rays = minkowski_sum(*region, cube);
        ASSERT_TRUE(by_rays);
        for (const double length : {1e-3, 1.0, 100.0}) {
            const auto cut = sum_by_cutting(*region, cube, length);
            ASSERT_TRUE(cut);
            EXPECT_FALSE(cut->obstructing.empty());
            const auto same = [](const HalfSpace& p, const HalfSpace& q) {
                return (p.normal - q.normal).norm() < 1e-7 && std::abs(p.offset - q.offset) < 1e-7;
            };
            std::vector<bool> is_found(by_rays->facet_count(), false);
            for (const std::uint32_t f : cut->remaining) {
                bool known = false;
                for (std::uint32_t g = 0; g < by_rays->facet_count(); ++g) {
                    if (same(cut->intermediate.half_space(f), by_rays->half_space(g))) {
                        known = true;
                        is_found[g] = true;
                    }
                }
                EXPECT_TRUE(known) << "length " << length;
            }
            EXPECT_EQ(std::ranges::count(is_found, false), 0) << "length " << length;
        }
    }
}

TEST(CutRays, RefusesBadLengths)
{
    const auto octant = test::hull_of({{0, 0, 0}}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    const double infinity = std::numeric_limits<double>::infinity();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double length : {0.0, -1.0, infinity, -infinity, nan}) {
        const auto cut = cut_rays(octant, length);
        ASSERT_FALSE(cut) << length;
        EXPECT_EQ(code_of(cut), ErrorCode::invalid_argument) << length;
        const auto sum = sum_by_cutting(octant, octant, length);
        ASSERT_FALSE(sum) << length;
        EXPECT_EQ(code_of(sum), ErrorCode::invalid_argument) << length;
    }
    for (const double length : {1e100, 1e308}) {
        const auto sum = sum_by_cutting(octant, octant, length);
        ASSERT_FALSE(sum) << length;
        EXPECT_EQ(code_of(sum), ErrorCode::limit_exceeded) << length;
    }
    EXPECT_EQ(cut_rays(octant, 2)->points().size(), 4U);
}

} // namespace
} // namespace proxima::unbounded_sum_test
