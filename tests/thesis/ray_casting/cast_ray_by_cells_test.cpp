#include "proxima/thesis.h"

#include "counted_allocations.h"
#include "index/test_meshes.h"
#include "octree/nasty_meshes.h"
#include "oracles/ray_hits.h"
#include "proxima/cast_ray.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "query/rays/test_rays.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace proxima::cast_ray_by_cells_test {
namespace {

using namespace testing;

/// With a root as tight as can be: rays touch the mesh where they only touch the root.
Octree octree_of(const TriangleMesh& mesh, int depth)
{
    const OctreeFrame root = tight_root(bounding_box(mesh), RootShape::cube);
    return build_octree(mesh,
                        {.max_depth = depth, .root = root, .classification = Classification::none})
        .value();
}

/// Whether the direction is shorter than the function's contract allows.
bool is_too_short(const Ray& ray, const TriangleMesh& mesh)
{
    const Box box = bounding_box(mesh);
    const double reach = (box.lower - ray.origin).cwiseAbs().maxCoeff() + box.extent().maxCoeff();
    return !(2 * reach < 0x1p1000 * ray.direction.cwiseAbs().maxCoeff());
}

/// Returns how many rays hit.
std::size_t expect_truth(const TriangleMesh& mesh, int depth, std::uint64_t seed, int rays)
{
    const Octree octree = octree_of(mesh, depth);
    RayGenerator generate(mesh, seed);
    std::size_t hits = 0;
    for (int i = 0; i < rays; ++i) {
        const Ray ray = generate();
        if (is_too_short(ray, mesh)) continue;
        const Faces faces = all_faces[static_cast<std::size_t>(i) % 3];
        const auto truth = closest_hit_by_brute_force(mesh, ray, faces);
        const std::size_t before = allocation_count();
        const auto found = closest_hit_by_cells(octree, mesh, ray, faces);
        EXPECT_EQ(allocation_count(), before);
        EXPECT_EQ(found, truth) << "seed " << seed << " ray " << i;
        hits += truth ? 1U : 0U;
        if (::testing::Test::HasFailure()) break;
    }
    return hits;
}

TEST(CastRayByCells, AnswersLikeBruteForceOnNamedMeshes)
{
    std::size_t hits = 0;
    std::uint64_t seed = 1;
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        hits += expect_truth(named.mesh, 5, seed++, 400);
    }
    EXPECT_GT(hits, 2'000U);
}

TEST(CastRayByCells, AnswersLikeBruteForceOnNastyMeshes)
{
    std::size_t hits = 0;
    for (std::uint32_t seed = 0; seed < 300; ++seed)
        hits += expect_truth(nasty_mesh(seed), static_cast<int>(seed % 6), seed, 60);
    EXPECT_GT(hits, 5'000U);
}

TEST(CastRayByCells, HitsWhatItOnlyTouchesOnTheBorderOfTheRoot)
{
    constexpr unsigned seed = 8;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> eighths(-8, 8);
    const TriangleMesh cube = sample_mesh("cube").value();
    const Octree octree = octree_of(cube, 3);
    const double half = bounding_box(cube).upper.x();
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        // Through a point of an edge or a corner, all in whole eighths.
        Vec3 at(eighths(random), 8, i % 8 == 0 ? 8 : -8);
        std::rotate(at.data(), at.data() + i % 3, at.data() + 3);
        const Vec3 direction(eighths(random), eighths(random), eighths(random));
        if (direction.isZero()) continue;
        const Ray ray{.origin = half / 8 * at - 2 * direction, .direction = direction};
        const auto truth = closest_hit_by_brute_force(cube, ray);
        ASSERT_EQ(closest_hit_by_cells(octree, cube, ray), truth) << i;
        hits += truth ? 1 : 0;
    }
    EXPECT_GT(hits, 1900);
}

TEST(CastRayByCells, AnswersLikeTheMeshIndexWithATightRoot)
{
    const TriangleMesh mesh = make_torus(60, 40);
    const auto octree = build_octree(mesh, {.classification = Classification::none});
    const MeshIndex index = ray_index_of(mesh);
    RayGenerator generate(mesh, 7);
    for (int i = 0; i < 3000; ++i) {
        const Ray ray = generate();
        ASSERT_EQ(closest_hit_by_cells(*octree, mesh, ray), closest_hit(index, ray)) << i;
    }
}

} // namespace
} // namespace proxima::cast_ray_by_cells_test
