#include "cli/fine_mesh.h"

#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

namespace proxima::fine_mesh_test {
namespace {

double area_of(const TriangleMesh& mesh)
{
    double area = 0;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        area += 0.5 * (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).norm();
    }
    return area;
}

TEST(FineMesh, PiecesAreSmallAndFaceAsTheirTriangle)
{
    const TriangleMesh cube = sample_mesh("cube").value();
    const TriangleMesh fine = finely_cut(cube).value();
    EXPECT_NEAR(area_of(fine), area_of(cube), 1e-12);
    EXPECT_EQ(fine.triangle_count(), 12U * 64 * 64); // 82 cuts would make them short enough
    const double length = std::sqrt(8.0) / 64;
    for (std::uint32_t i = 0; i < fine.triangle_count(); ++i) {
        const Triangle piece = fine.triangle(TriangleId{i});
        for (int side = 0; side < 3; ++side)
            EXPECT_LE((piece[(side + 1) % 3] - piece[side]).norm(), 1.000001 * length);
        const Vec3 normal = (piece[1] - piece[0]).cross(piece[2] - piece[0]);
        EXPECT_GT(normal.dot(piece[0] + piece[1] + piece[2]), 0); // outward, about the origin
    }
}

TEST(FineMesh, HasNoMoreTrianglesThanAsked)
{
    const TriangleMesh ball = sample_mesh("icosphere:3").value();
    const TriangleMesh fine = finely_cut(ball, 6000).value();
    EXPECT_LE(fine.triangle_count(), 6000U);
    EXPECT_GT(fine.triangle_count(), ball.triangle_count());
    EXPECT_EQ(finely_cut(ball, 10)->triangle_count(), ball.triangle_count());
    EXPECT_NEAR(area_of(fine), area_of(ball), 1e-12);
}

TEST(FineMesh, LeavesPointsAndHugeMeshesAlone)
{
    const TriangleMesh points = mesh_of_points({{1, 2, 3}, {1, 2, 3}}).value();
    EXPECT_EQ(finely_cut(points)->triangle_count(), 2U);
    const TriangleMesh huge =
        make_triangle_mesh({{-1e308, 0, 0}, {1e308, 0, 0}, {0, 1e308, 0}}, {{0, 1, 2}}).value();
    EXPECT_GE(finely_cut(huge)->triangle_count(), 1U);
}

} // namespace
} // namespace proxima::fine_mesh_test
