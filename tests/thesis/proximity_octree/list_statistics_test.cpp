#include "thesis/proximity_octree/list_statistics.h"

#include "index/index_parts.h"
#include "index/listed_index.h"
#include "index/lists/proximity_lists.h"
#include "proxima/sample_meshes.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include <array>
#include <gtest/gtest.h>
#include <numeric>

namespace proxima::list_statistics_test {
namespace {

TEST(ListStatistics, CountLengths)
{
    const std::array<std::uint32_t, 5> lengths = {3, 0, 3, 7, 1};
    const ListStatistics statistics = list_statistics(lengths);
    EXPECT_EQ(statistics.cells, 5U);
    EXPECT_EQ(statistics.max, 7U);
    EXPECT_DOUBLE_EQ(statistics.mean, 14.0 / 5);
    EXPECT_EQ(statistics.weights, (std::vector<double>{1, 1, 0, 2, 0, 0, 0, 1}));
    EXPECT_DOUBLE_EQ(statistics.share_up_to(0), 0.2);
    EXPECT_DOUBLE_EQ(statistics.share_up_to(3), 0.8);
    EXPECT_DOUBLE_EQ(statistics.share_up_to(100), 1);
}

TEST(ListStatistics, WeightLengths)
{
    const std::array<std::uint32_t, 3> lengths = {2, 4, 2};
    const std::array weights = {1.0, 6.0, 0.5};
    const ListStatistics statistics = list_statistics(lengths, weights);
    EXPECT_DOUBLE_EQ(statistics.total_weight, 7.5);
    EXPECT_DOUBLE_EQ(statistics.mean, 27.0 / 7.5);
    EXPECT_DOUBLE_EQ(statistics.share_up_to(2), 0.2);
}

TEST(ListStatistics, OfNoListsAreZero)
{
    const ListStatistics statistics = list_statistics({});
    EXPECT_EQ(statistics.cells, 0U);
    EXPECT_EQ(statistics.mean, 0);
    EXPECT_TRUE(statistics.weights.empty());
    EXPECT_EQ(statistics.share_up_to(5), 0);
    const std::array<std::uint32_t, 1> lengths = {2};
    const std::array weights = {0.0};
    EXPECT_EQ(list_statistics(lengths, weights).mean, 0);
}

TEST(ListStatistics, OuterCellsAreOutsideTheCircumscribedSphere)
{
    const TriangleMesh mesh = make_octahedron();
    const MeshSphere sphere = circumscribed_sphere(mesh);
    EXPECT_EQ(sphere.center, Vec3::Zero());
    EXPECT_EQ(sphere.squared_radius, 1);
    EXPECT_TRUE(sphere.is_outside({{1, -1, -1}, {2, 1, 1}}));
    EXPECT_FALSE(sphere.is_outside({{0.999, -1, -1}, {2, 1, 1}}));
    EXPECT_TRUE(sphere.is_outside({{0.6, 0.6, 0.6}, {2, 2, 2}}));
    EXPECT_FALSE(sphere.is_outside({{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}}));
    const auto octree =
        *build_thesis_proximity_octree(mesh, {.max_depth = 3, .thresholds = {0, 0, 0}});
    std::size_t outside = 0;
    octree.for_each_leaf([&](const ThesisCell& cell) {
        if (!sphere.is_outside(octree.box(cell))) return;
        ++outside;
        EXPECT_EQ(octree.type(cell), CellClass::outer);
        EXPECT_GT(octree.list_length(cell), 0U);
    });
    EXPECT_EQ(outer_list_lengths(octree, sphere).size(), outside);
    EXPECT_GT(outside, 100U);
}

TEST(ListStatistics, AgreeWithTheCountsOfTheBuild)
{
    const std::array meshes = {make_octahedron(), *sample_mesh("sphere:16x16"),
                               *sample_mesh("torus:40x20"), *sample_mesh("spaceship:2000")};
    int with_runs = 0;
    for (const TriangleMesh& mesh : meshes) {
        // Tables of several depths; a small budget leaves runs of several blocks.
        for (const std::uint64_t bytes_per_triangle : {200U, 600U, 2000U}) {
            const std::uint64_t budget = 4096 + bytes_per_triangle * mesh.triangle_count();
            const auto index = *testing::listed_index(mesh, {.list_bytes = budget});
            const LeafLists lists = list_lengths(*index.parts().lists());
            const ProximityStatistics& counted = index.parts().lists()->statistics();
            ASSERT_EQ(lists.volumes.size(), lists.lengths.size());
            EXPECT_EQ(std::accumulate(lists.volumes.begin(), lists.volumes.end(), 0.0), 1.0);
            const auto references =
                std::accumulate(lists.lengths.begin(), lists.lengths.end(), std::uint64_t{0});
            EXPECT_EQ(list_statistics(lists.lengths).max, counted.max_list);
            EXPECT_EQ(lists.lengths.size(), counted.leaves);
            EXPECT_EQ(references, counted.references);
            if (counted.max_list > 32) ++with_runs;
        }
    }
    EXPECT_GE(with_runs, 3);
}

} // namespace
} // namespace proxima::list_statistics_test
