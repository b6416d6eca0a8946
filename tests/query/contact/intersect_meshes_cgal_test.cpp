// Pairs of triangles that meet against CGAL's exact kernel.
#include "geometry/exact_predicates.h"
#include "index/test_meshes.h"
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/octree.h"
#include "query/contact/test_poses.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/intersections.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace proxima::intersect_meshes_cgal_test {
namespace {

using namespace testing;
using Exact = CGAL::Exact_predicates_exact_constructions_kernel;

Exact::Point_3 exact(const Vec3& p)
{
    return {p.x(), p.y(), p.z()};
}

/// CGAL wants no degenerate triangles: these are left out on both sides.
std::vector<TrianglePair> pairs_by_cgal(const TriangleMesh& mesh_a, const TriangleMesh& mesh_b,
                                        const RigidTransform& pose)
{
    std::vector<TrianglePair> pairs;
    for (std::uint32_t i = 0; i < mesh_a.triangle_count(); ++i) {
        const Triangle a = mesh_a.triangle(TriangleId{i});
        if (is_degenerate(a)) continue;
        const Exact::Triangle_3 exact_a(exact(a[0]), exact(a[1]), exact(a[2]));
        for (std::uint32_t j = 0; j < mesh_b.triangle_count(); ++j) {
            const Triangle b = pose(mesh_b.triangle(TriangleId{j}));
            if (is_degenerate(b)) continue;
            if (CGAL::do_intersect(exact_a,
                                   Exact::Triangle_3(exact(b[0]), exact(b[1]), exact(b[2]))))
                pairs.push_back({TriangleId{i}, TriangleId{j}});
        }
    }
    return pairs;
}

MeshIndex index_of(const TriangleMesh& mesh)
{
    return build_mesh_index(mesh).value();
}

void compare(const TriangleMesh& mesh_a, const TriangleMesh& mesh_b, int poses, std::uint64_t seed,
             std::size_t& met)
{
    const MeshIndex a = index_of(mesh_a);
    const MeshIndex b = index_of(mesh_b);
    PoseGenerator generate(mesh_a, mesh_b, seed);
    for (int i = 0; i < poses; ++i) {
        const RigidTransform pose = generate();
        std::vector<TrianglePair> pairs = intersecting_pairs(a, b, pose);
        std::erase_if(pairs, [&](const TrianglePair& pair) {
            return is_degenerate(mesh_a.triangle(pair.a)) ||
                   is_degenerate(pose(mesh_b.triangle(pair.b)));
        });
        ASSERT_EQ(pairs, pairs_by_cgal(mesh_a, mesh_b, pose)) << "seed " << seed << ", pose " << i;
        met += pairs.size();
    }
}

TEST(IntersectMeshesAndCgal, FindTheSamePairs)
{
    std::size_t met = 0;
    for (std::uint32_t seed = 0; seed < 30; ++seed) {
        compare(nasty_mesh(seed), grid_mesh(seed), 3, seed, met);
        compare(grid_mesh(seed), grid_mesh(seed + 7), 4, seed, met);
        if (HasFatalFailure()) return;
    }
    compare(torus_mesh(1.0, 0.4, 12, 8), sphere_mesh(Vec3::Zero(), 0.7, 6, 8), 12, 7, met);
    EXPECT_GT(met, 1000U);
}

} // namespace
} // namespace proxima::intersect_meshes_cgal_test
