#include "thesis/haptic_interaction/thesis_patches.h"

#include "counted_allocations.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "thesis/proximity_octree/thesis_closest.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace proxima::thesis_patches_test {
namespace {

std::vector<std::uint32_t> ids_of(const ContactPatch& patch)
{
    std::vector<std::uint32_t> ids;
    for (const ContactTriangle& triangle : patch.triangles()) ids.push_back(to_index(triangle.id));
    std::ranges::sort(ids);
    return ids;
}

class ThesisPatchesTest : public ::testing::Test {
protected:
    const TriangleMesh mesh = make_sphere(30, 30);
    const Topology topology = *build_topology(mesh);
    const ThesisProximityOctree cells = *build_thesis_proximity_octree(mesh, topology);
    const MeshIndex index = *build_mesh_index(mesh);
    RingPatches rings{index, mesh, topology};
    ThesisPatches patches{cells, mesh, topology, rings};
    ContactPatch made;
    ContactPatch expected;
};

TEST_F(ThesisPatchesTest, AgreeWithTheFastClosestFeatureOutside)
{
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> coordinate(-1.4, 1.4);
    int compared = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 point(coordinate(random), coordinate(random), coordinate(random));
        const ClosestFeature closest = *closest_feature(index, point);
        // Edges between the coplanar halves of a quad are features of the index alone.
        if (point.norm() < 1.001 || closest.feature.kind == FeatureKind::edge) continue;
        const std::size_t before = testing::allocation_count();
        ASSERT_TRUE(patches.fill(made, point, point, i % 4));
        ASSERT_EQ(testing::allocation_count(), before);
        rings.fill(expected, point, i % 4);
        ASSERT_EQ(ids_of(made), ids_of(expected)) << "point " << i;
        ++compared;
    }
    EXPECT_GT(compared, 200);
}

TEST_F(ThesisPatchesTest, StayWithTheProxyWhileTheDeviceIsInside)
{
    const Vec3 proxy(0.01, 0.02, 1.0005);
    const Vec3 inside(0.01, 0.02, 0.9);
    ASSERT_TRUE(patches.fill(made, inside, proxy, 2));
    rings.fill(expected, proxy, 2);
    EXPECT_EQ(ids_of(made), ids_of(expected));
    EXPECT_EQ(made.clearance, 0);
    // Both inside: the last feature.
    ASSERT_TRUE(patches.fill(made, inside, inside, 2));
    EXPECT_EQ(ids_of(made), ids_of(expected));
}

TEST_F(ThesisPatchesTest, FollowAProxyThatRoundingPutsBehindTheSurface)
{
    // Where the octree has no answer for the proxy itself.
    const Triangle triangle = mesh.triangle(TriangleId{400});
    const Vec3 centroid = (triangle[0] + triangle[1] + triangle[2]) / 3;
    const Vec3 proxy = centroid * (1 - 1e-12);
    ASSERT_FALSE(closest_feature(cells, mesh, topology, proxy));
    const Vec3 elsewhere(0, 0, -1.2);
    ASSERT_TRUE(patches.fill(made, elsewhere, elsewhere, 1));
    ASSERT_TRUE(patches.fill(made, 0.9 * proxy, proxy, 1));
    rings.fill(expected, centroid, 1);
    EXPECT_EQ(ids_of(made), ids_of(expected));
}

TEST_F(ThesisPatchesTest, AskForThePointOfTheRootClosestToADeviceOutside)
{
    const Vec3 outside(0.02, 0.03, 40);
    ASSERT_FALSE(closest_feature(cells, mesh, topology, outside));
    ASSERT_TRUE(patches.fill(made, outside, outside, 2));
    const Box root = cell_box(cells.frame(), CellKey{});
    rings.fill(expected, Vec3(0.02, 0.03, root.upper.z()), 2);
    EXPECT_EQ(ids_of(made), ids_of(expected));
    EXPECT_EQ(made.clearance, 0);
}

TEST_F(ThesisPatchesTest, AreEmptyBeforeAnyFeatureIsFound)
{
    EXPECT_FALSE(patches.fill(made, Vec3::Zero(), Vec3::Zero(), 2));
}

} // namespace
} // namespace proxima::thesis_patches_test
