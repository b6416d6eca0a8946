#include "proxima/thesis.h"

#include "octree/nasty_meshes.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "query/contact/test_poses.h"
#include "query/rays/test_rays.h"
#include "thesis/object_intersections/cancellable_cells.h"

#include <gtest/gtest.h>

namespace proxima::intersect_by_cells_test {
namespace {

using namespace testing;

Octree octree_of(const TriangleMesh& mesh, int depth)
{
    return build_octree(mesh, {.max_depth = depth, .classification = Classification::none}).value();
}

TEST(IntersectByCells, FindsThePairsOfBruteForceOnNastyMeshes)
{
    std::size_t pairs = 0;
    for (std::uint32_t seed = 0; seed < 150; ++seed) {
        const TriangleMesh a = nasty_mesh(seed);
        const TriangleMesh b = nasty_mesh(seed + 1000);
        const Octree cells_a = octree_of(a, static_cast<int>(seed % 5));
        const Octree cells_b = octree_of(b, static_cast<int>(seed % 4));
        PoseGenerator generate(a, b, seed);
        for (int i = 0; i < 6; ++i) {
            SCOPED_TRACE(::testing::Message() << "seed " << seed << " pose " << i);
            const RigidTransform pose = generate();
            const auto found = intersect_by_cells({a, cells_a}, {b, cells_b}, pose);
            ASSERT_EQ(found.pairs, pairs_by_brute_force(a, b, pose));
            ASSERT_GE(found.triangle_tests, found.pairs.size());
            pairs += found.pairs.size();
        }
    }
    EXPECT_GT(pairs, 500U);
}

TEST(IntersectByCells, FindsThePairsOfTheMeshIndex)
{
    const TriangleMesh a = make_torus(60, 40);
    const TriangleMesh b = make_sphere(30, 30);
    const Octree cells_a = octree_of(a, 5);
    const Octree cells_b = octree_of(b, 5);
    const MeshIndex index_a = ray_index_of(a);
    const MeshIndex index_b = ray_index_of(b);
    PoseGenerator generate(a, b, 3);
    for (int i = 0; i < 40; ++i) {
        const RigidTransform pose = generate();
        EXPECT_EQ(intersect_by_cells({a, cells_a}, {b, cells_b}, pose).pairs,
                  intersecting_pairs(index_a, index_b, pose))
            << i;
    }
}

TEST(IntersectByCells, CountsTheTestsOfCells)
{
    const TriangleMesh cube = make_cube();
    const Octree roots = octree_of(cube, 0);
    EXPECT_EQ(intersect_by_cells({cube, roots}, {cube, roots}).cell_tests, 1U);
    // All eight octants hold triangles, and meet at the middle: one level of A, then one of B.
    const Octree octants = octree_of(cube, 1);
    const auto found = intersect_by_cells({cube, octants}, {cube, octants});
    EXPECT_EQ(found.cell_tests, 1U + 8U + 8U * 8U);
    EXPECT_EQ(found.cell_pairs, 8U * 8U);
    // Far from each other.
    const auto apart =
        intersect_by_cells({cube, octants}, {cube, octants}, {Mat3::Identity(), Vec3(100, 0, 0)});
    EXPECT_EQ(apart.cell_tests, 1U);
    EXPECT_EQ(apart.cell_pairs, 0U);
}

/// Two roots that are leaves: all pairs are candidates, and none may be listed before it is tested.
TEST(IntersectByCells, StopsBeforeItHasListedAllPairsOfLongLists)
{
    const TriangleMesh mesh = make_sphere(40, 40);
    const Octree cells = octree_of(mesh, 0);
    const std::uint64_t all = std::uint64_t{mesh.triangle_count()} * mesh.triangle_count();
    const auto whole = intersect_by_cells({mesh, cells}, {mesh, cells});
    EXPECT_EQ(whole.triangle_tests, all);
    EXPECT_EQ(whole.cell_pairs, 1U);
    EXPECT_EQ(whole.pairs, pairs_by_brute_force(mesh, mesh, {}));
    Progress progress;
    progress.cancel();
    const auto stopped = intersect_by_cells({mesh, cells}, {mesh, cells}, {}, &progress);
    EXPECT_LT(stopped.triangle_tests, all / 2);
}

} // namespace
} // namespace proxima::intersect_by_cells_test
