#include "proxima/octree.h"

#include "octree/slow_builder.h"
#include "octree/small_meshes.h"

#include <gtest/gtest.h>

namespace proxima::statistics_test {
namespace {

using namespace testing;

/// The thesis's sphere: 100 x 100, radius 1, the root exactly on it.
const TriangleMesh& thesis_sphere()
{
    static const TriangleMesh mesh = sphere_mesh(Vec3::Zero(), 1.0, 100, 100);
    return mesh;
}

OctreeFrame unit_root()
{
    return {Vec3::Constant(-1.0), Vec3::Constant(2.0)};
}

TEST(Statistics, ReproducesTable21OfTheThesis)
{
    struct Row {
        int depth;
        std::uint64_t total, leaves;
        double percent;
    };
    for (const Row& row : {Row{1, 9, 8, 100.0}, Row{2, 73, 64, 87.5}, Row{3, 521, 456, 59.6},
                           Row{4, 2697, 2360, 49.2}}) {
        const Octree octree =
            slow_octree(thesis_sphere(), {.max_depth = row.depth, .root = unit_root()});
        const OctreeStatistics statistics = octree_statistics(octree);
        EXPECT_EQ(statistics.total, row.total);
        EXPECT_EQ(statistics.leaves, row.leaves);
        EXPECT_NEAR(statistics.occupied_percent, row.percent, 0.05);
        EXPECT_EQ(statistics.depth_reached, row.depth);
        EXPECT_EQ(statistics.references, octree.references().size());
        EXPECT_EQ(statistics.boundary, statistics.occupied_leaves);
        EXPECT_EQ(statistics.unclassified, statistics.leaves - statistics.occupied_leaves);
        EXPECT_EQ(statistics.bytes, octree.bytes());
    }
}

TEST(Statistics, AgreesWithACountOfEveryCell)
{
    const TriangleMesh mesh = torus_mesh(1.0, 0.4, 24, 12);
    for (const Subdivision subdivision : {Subdivision::adaptive, Subdivision::uniform}) {
        const Octree octree =
            slow_octree(mesh, {.max_depth = 4, .threshold = 5, .subdivision = subdivision});
        std::vector<double> all;
        std::vector<double> occupied;
        std::uint64_t cells = 0;
        std::array<std::uint64_t, max_octree_depth + 1> histogram{};
        const std::function<void(const Cell&)> visit = [&](const Cell& cell) {
            ++cells;
            if (octree.is_leaf(cell)) {
                const auto count = static_cast<double>(octree.triangles(cell).size());
                all.push_back(count);
                if (count > 0) occupied.push_back(count);
                ++histogram[static_cast<std::size_t>(depth(cell.key))];
                return;
            }
            for (int octant = 0; octant < 8; ++octant) visit(octree.child(cell, octant));
        };
        visit(octree.root());
        const auto mean = [](const std::vector<double>& values) {
            return std::accumulate(values.begin(), values.end(), 0.0) /
                   static_cast<double>(values.size());
        };
        const auto deviation = [&](const std::vector<double>& values) {
            double sum = 0;
            for (const double v : values) sum += (v - mean(values)) * (v - mean(values));
            return std::sqrt(sum / static_cast<double>(values.size()));
        };
        const OctreeStatistics statistics = octree_statistics(octree);
        EXPECT_EQ(statistics.total, cells);
        EXPECT_EQ(statistics.leaves, all.size());
        EXPECT_EQ(statistics.occupied_leaves, occupied.size());
        EXPECT_EQ(statistics.min_triangles, *std::min_element(occupied.begin(), occupied.end()));
        EXPECT_EQ(statistics.max_triangles, *std::max_element(occupied.begin(), occupied.end()));
        EXPECT_DOUBLE_EQ(statistics.mean_triangles, mean(occupied));
        EXPECT_DOUBLE_EQ(statistics.mean_all_leaves, mean(all));
        EXPECT_NEAR(statistics.std_triangles, deviation(occupied), 1e-12);
        EXPECT_NEAR(statistics.std_all_leaves, deviation(all), 1e-12);
        EXPECT_EQ(statistics.leaves_at_depth, histogram);
    }
}

TEST(Statistics, OfOneLeafHasNoSpread)
{
    const TriangleMesh mesh = cube_mesh(Vec3::Zero(), 1.0);
    const OctreeStatistics statistics = octree_statistics(slow_octree(mesh, {.max_depth = 0}));
    EXPECT_EQ(statistics.total, 1U);
    EXPECT_EQ(statistics.min_triangles, 12U);
    EXPECT_EQ(statistics.mean_triangles, 12.0);
    EXPECT_EQ(statistics.std_triangles, 0.0);
    EXPECT_EQ(statistics.occupied_percent, 100.0);
    EXPECT_EQ(statistics.depth_reached, 0);
}

TEST(Statistics, OfTheDefaultOctreeAreZero)
{
    const Octree octree;
    EXPECT_EQ(octree_statistics(octree).total, 0U);
    EXPECT_TRUE(octree.is_leaf(octree.root()));
    EXPECT_TRUE(octree.triangles(octree.root()).empty());
}

} // namespace
} // namespace proxima::statistics_test
