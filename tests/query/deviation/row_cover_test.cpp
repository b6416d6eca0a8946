// Bounds of parts by the rows of B along them, against samples and every triangle of B.
#include "query/deviation/row_cover.h"

#include "index/test_meshes.h"
#include "proxima/sample_meshes.h"
#include "query/deviation/sampled_deviation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace proxima::row_cover_test {
namespace {

using namespace testing;

MeshIndex index_of(const TriangleMesh& mesh)
{
    return build_mesh_index(mesh).value();
}

/// The triangle with weights of its corners that sum to 1.
Vec3 point_of(const std::array<Vec3, 3>& corners, double s, double t)
{
    return corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0]);
}

/// Some triangles of A, or parts of them, from the rows nearest to their corners or from any row.
void expect_bounds(const TriangleMesh& a, const TriangleMesh& b, std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const MeshIndex index_a = index_of(a);
    const MeshIndex index_b = index_of(b);
    const auto pair = SurfacePair::make(index_a, index_b, {});
    ASSERT_TRUE(pair);
    const RowNeighbors neighbors(pair->b());
    RowCover cover(*pair, neighbors);
    const double slack = 1e-13 * size_of(a, b);
    for (int round = 0; round < 12; ++round) {
        const auto row = static_cast<std::uint32_t>(random() % pair->a().triangle_count());
        MeasuredPart part{.corners = pair->a().triangle(row).vertices};
        if (round % 3 == 2) {
            for (Vec3& corner : part.corners) {
                const double s = unit(random);
                corner = point_of(pair->a().triangle(row).vertices, s, (1 - s) * unit(random));
            }
        }
        for (std::size_t k = 0; k < 3; ++k) {
            part.nearest[k] = pair->nearest(part.corners[k], HUGE_VAL);
            if (round % 4 == 3) {
                part.nearest[k].row =
                    static_cast<std::uint32_t>(random() % pair->b().triangle_count());
            }
        }
        double farthest = 0;
        constexpr int cuts = 12;
        for (int i = 0; i <= cuts; ++i) {
            for (int j = 0; i + j <= cuts; ++j) {
                const Vec3 p = point_of(part.corners, static_cast<double>(i) / cuts,
                                        static_cast<double>(j) / cuts);
                farthest = std::max(farthest, distance_from(b, p));
            }
        }
        for (const double enough : {0.0, 0.5 * farthest, farthest, 1.01 * farthest}) {
            const CoverBound bound = cover.bound(part, enough);
            EXPECT_GE(bound.upper, farthest - slack) << "row " << row << ", enough " << enough;
            if (!std::isfinite(bound.upper)) continue;
            EXPECT_LE(distance_from(b, bound.point), bound.upper + slack);
            EXPECT_LE(
                (closest_point(Triangle{part.corners}, bound.point).point - bound.point).norm(),
                slack);
        }
    }
}

TEST(RowCover, BoundsWhatSamplesFind)
{
    const std::vector<NamedMesh> meshes = {
        {"sphere", sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 8, 10)},
        {"finer", sphere_mesh(Vec3(0.1, 0.21, 0.3), 1.01, 21, 24)},
        {"open", without(sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 13, 12),
                         [](std::size_t i) { return i % 5 == 0; })},
        {"torus", sample_mesh("torus:24x12").value()},
        {"cube", cube_mesh(Vec3::Zero(), 1.0)},
        {"slivers", sliver_strip()},
        {"fans", fans()},
        {"a point", mesh_of({Vec3(0.1, 0.2, 0.3)}, {{0, 0, 0}})},
        {"a segment", mesh_of({Vec3(0, 0, 0), Vec3(1, 2, 3)}, {{0, 1, 1}})}};
    std::uint64_t seed = 0;
    for (const NamedMesh& a : meshes) {
        for (const NamedMesh& b : meshes) {
            SCOPED_TRACE(a.name + ", " + b.name + ", seed " + std::to_string(++seed));
            expect_bounds(a.mesh, b.mesh, seed);
            if (HasFatalFailure()) return;
        }
    }
    for (std::uint32_t grid = 1; grid <= 40; ++grid) {
        SCOPED_TRACE("grids " + std::to_string(grid) + " and " + std::to_string(grid + 100));
        expect_bounds(grid_mesh(grid), grid_mesh(grid + 100), grid);
        if (HasFatalFailure()) return;
    }
}

TEST(RowCover, IsThatOfSurfacesAlongEachOther)
{
    // A triangle over a pyramid of four: the highest point is over its tip, and no corner of any triangle.
    const double height = 0.25;
    const TriangleMesh pyramid = mesh_of(
        {Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0), Vec3(0, 0, -height)},
        {{0, 1, 4}, {1, 2, 4}, {4, 2, 3}, {0, 4, 3}});
    const TriangleMesh lid =
        mesh_of({Vec3(-0.5, -0.4, 0), Vec3(0.5, -0.4, 0), Vec3(0, 0.6, 0)}, {{0, 1, 2}});
    const auto pair = SurfacePair::make(index_of(lid), index_of(pyramid), {});
    ASSERT_TRUE(pair);
    const RowNeighbors neighbors(pair->b());
    RowCover cover(*pair, neighbors);
    const double truth = height / std::sqrt(1 + height * height);
    for (std::uint32_t first = 0; first < 4; ++first) {
        MeasuredPart part{.corners = pair->a().triangle(0).vertices};
        part.nearest[0].row = first;
        const CoverBound bound = cover.bound(part, 0);
        EXPECT_NEAR(bound.upper, truth, 1e-15) << "from row " << first;
        EXPECT_NEAR(bound.point.norm(), 0, 1e-15);
        EXPECT_GT(bound.cuts, 1U);
        // A bound that suffices is not cut further.
        EXPECT_EQ(cover.bound(part, 9).cuts, 1U);
    }
}

TEST(RowNeighbors, AreTheRowsWithAnEdge)
{
    for (const TriangleMesh& mesh :
         {sample_mesh("icosphere:2").value(), fans(), sliver_strip(), grid_mesh(3)}) {
        const MeshIndex index = index_of(mesh);
        const auto pair = SurfacePair::make(index, index, {});
        ASSERT_TRUE(pair);
        const RowNeighbors neighbors(pair->b());
        const std::uint32_t count = pair->b().triangle_count();
        for (std::uint32_t row = 0; row < count; ++row) {
            for (const std::uint32_t edge : edges_of(pair->b(), row)) {
                const std::uint32_t found = neighbors.across(edge, row);
                bool is_there = false; // another one with the edge, among all
                for (std::uint32_t other = 0; other < count && edge < pair->b().edge_count();
                     ++other) {
                    const auto edges = edges_of(pair->b(), other);
                    is_there =
                        is_there || (other != row && std::ranges::find(edges, edge) != edges.end());
                }
                ASSERT_EQ(found != RowNeighbors::none, is_there);
                if (!is_there) continue;
                EXPECT_NE(found, row);
                const auto edges = edges_of(pair->b(), found);
                EXPECT_NE(std::ranges::find(edges, edge), edges.end());
            }
        }
    }
}

} // namespace
} // namespace proxima::row_cover_test
