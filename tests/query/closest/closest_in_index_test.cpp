#include "base/simd.h"
#include "counted_allocations.h"
#include "index/build_mesh_index.h"
#include "index/listed_index.h"
#include "index/test_meshes.h"
#include "query/closest/brute_force.h"
#include "query/closest/closest_feature.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

namespace proxima {
namespace {

using namespace testing;

void expect_same(const ClosestFeature& found, const ClosestFeature& truth)
{
    EXPECT_EQ(found.feature, truth.feature);
    EXPECT_EQ(found.triangle, truth.triangle);
    EXPECT_EQ(found.point, truth.point);
    EXPECT_EQ(found.barycentric, truth.barycentric);
    EXPECT_EQ(found.squared_distance, truth.squared_distance);
}

void expect_same(const std::optional<ClosestFeature>& found, const ClosestFeature& truth)
{
    ASSERT_TRUE(found.has_value());
    expect_same(*found, truth);
}

TEST(ClosestInIndex, AnswersAsBruteForceToTheLastBit)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const Topology topology = build_topology(named.mesh).value();
        const MeshIndex index = build_mesh_index(named.mesh).value();
        for (const Vec3& p : proximity_points(named.mesh, 600, 8)) {
            SCOPED_TRACE(p.transpose());
            expect_same(closest_feature(index, p),
                        closest_feature_by_brute_force(named.mesh, topology, p));
            if (HasFailure()) return;
        }
    }
}

TEST(ClosestInIndex, AnswersAsBruteForceOnManyRandomMeshes)
{
    for (std::uint32_t seed = 100; seed < 400; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = seed % 2 == 0 ? nasty_mesh(seed) : grid_mesh(seed);
        const Topology topology = build_topology(mesh).value();
        const MeshIndex index = build_mesh_index(mesh).value();
        for (const Vec3& p : proximity_points(mesh, 60, seed)) {
            SCOPED_TRACE(p.transpose());
            expect_same(closest_feature(index, p),
                        closest_feature_by_brute_force(mesh, topology, p));
            if (HasFailure()) return;
        }
    }
}

} // namespace
} // namespace proxima
