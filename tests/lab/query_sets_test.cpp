// Sets of queries lie where they are said to lie.
#include "lab/query_sets.h"

#include "index/test_meshes.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

namespace proxima::query_sets_test {
namespace {

TEST(QuerySets, LieWhereTheirNamesSay)
{
    for (const double shift : {0.0, 1e9}) {
        SCOPED_TRACE(shift);
        const TriangleMesh mesh =
            testing::moved(sample_mesh("torus:30x20").value(),
                           [&](const Vec3& p) { return Vec3(3 * p + Vec3(shift, 0, -shift)); });
        const MeshIndex index = build_mesh_index(mesh).value();
        const Box box = bounding_box(mesh);
        const double diagonal = box.extent().norm();
        const auto sets = query_sets(mesh, 3000, 5);
        const auto again = query_sets(mesh, 3000, 5);
        const auto distance = [&](const Vec3& p) {
            return std::sqrt(closest_feature(index, p)->squared_distance);
        };
        const double rounding = 1e-15 * shift;
        double widest = 0;
        double farthest = 0;
        for (std::size_t i = 0; i < 3000; ++i) {
            for (std::size_t set = 0; set < 3; ++set)
                ASSERT_EQ(sets[set].points[i], again[set].points[i]);
            const Vec3 part =
                (sets[0].points[i] - box.center()).cwiseQuotient(box.extent()).cwiseAbs();
            widest = std::max(widest, part.maxCoeff());
            farthest = std::max(farthest, distance(sets[1].points[i]));
            // In a cell with a point of the surface.
            ASSERT_LE(distance(sets[2].points[i]), 0.0174 * diagonal + rounding);
            if (i == 0) continue;
            const double step = (sets[2].points[i] - sets[2].points[i - 1]).norm();
            ASSERT_NEAR(step, 1e-4 * diagonal, 1e-9 * diagonal + rounding);
        }
        EXPECT_GT(widest, 0.59);
        EXPECT_LE(widest, 0.6 + 1e-9);
        EXPECT_GT(farthest, 0.009 * diagonal);
        EXPECT_LE(farthest, 0.01 * diagonal + rounding);
    }
}

TEST(QuerySets, AreFiniteForMeshesWithoutExtentOrArea)
{
    const std::vector<Vec3> corners = {Vec3(1, 2, 3), Vec3(2, 3, 4)};
    for (const TriangleCorners triangle : {TriangleCorners{0, 0, 0}, TriangleCorners{0, 1, 0}}) {
        const TriangleMesh mesh = make_triangle_mesh(corners, {triangle}).value();
        for (const QuerySet& set : query_sets(mesh, 100, 1)) {
            ASSERT_EQ(set.points.size(), 100U);
            for (const Vec3& point : set.points) ASSERT_TRUE(point.allFinite()) << set.name;
        }
    }
}

} // namespace
} // namespace proxima::query_sets_test
