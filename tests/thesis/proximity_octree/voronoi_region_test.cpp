#include "thesis/proximity_octree/voronoi_region.h"

#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <random>

namespace proxima::voronoi_region_test {
namespace {

TEST(VoronoiRegion, OfASphereIsTheIntersectionOfTheHalfSpacesOfTheThesis)
{
    const TriangleMesh sphere = make_sphere(10, 10);
    for (std::uint32_t t = 0; t < sphere.triangle_count(); t += 7) {
        const Triangle triangle = sphere.triangle(TriangleId{t});
        const auto region = voronoi_region_of_face(triangle);
        ASSERT_TRUE(region);
        EXPECT_EQ(region->facet_count(), 4U);
        std::mt19937 random(t);
        std::uniform_real_distribution<double> coordinate(-3, 3);
        const Vec3 n = scaled_normal(triangle);
        for (int i = 0; i < 200; ++i) {
            const Vec3 x{coordinate(random), coordinate(random), coordinate(random)};
            bool inside = n.dot(x - triangle[0]) >= 0; // (4.4)
            for (int j = 0; j < 3; ++j) {              // (4.3) with (4.5)
                const Vec3 u = triangle[(j + 1) % 3] - triangle[j];
                inside = inside && u.cross(n).dot(x - triangle[j]) <= 0;
            }
            bool in_region = true;
            for (std::uint32_t f = 0; f < region->facet_count(); ++f) {
                const HalfSpace plane = region->half_space(f);
                in_region = in_region && plane.normal.dot(x) <= plane.offset;
            }
            EXPECT_EQ(in_region, inside);
        }
    }
    // Coplanar faces at an edge: the region is a strip, not nothing.
    const auto strip = voronoi_region_of_edge({0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 0, 2});
    ASSERT_TRUE(strip);
    EXPECT_EQ(strip->dimension(), 2);
    EXPECT_FALSE(voronoi_region_of_face({{Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(2, 2, 2)}}));
}

} // namespace
} // namespace proxima::voronoi_region_test
