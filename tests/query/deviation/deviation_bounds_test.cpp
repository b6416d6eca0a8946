// Deviations where much must be cut, means whose bounds can be told to the last bits, and what they report.
#include "index/test_meshes.h"
#include "proxima/mesh_deviation.h"
#include "proxima/mesh_index.h"
#include "query/deviation/sampled_deviation.h"

#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace proxima::deviation_bounds_test {
namespace {

using namespace testing;

/// Two triangles in the plane z = height, over [-1, 1] x [-width, width].
MeshIndex strip(double width, double height)
{
    return build_mesh_index(mesh_of({Vec3(-1, -width, height), Vec3(1, -width, height),
                                     Vec3(1, width, height), Vec3(-1, width, height)},
                                    {{0, 1, 2}, {0, 2, 3}}))
        .value();
}

/// A square of 32 x 32 cells over [-1, 1]^2, its vertices at random heights up to 1e-3.
TriangleMesh bumpy_sheet(std::uint32_t seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> height(0, 1e-3);
    constexpr std::uint32_t n = 32;
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t j = 0; j <= n; ++j) {
        for (std::uint32_t i = 0; i <= n; ++i)
            positions.emplace_back(2.0 * i / n - 1, 2.0 * j / n - 1, height(random));
    }
    for (std::uint32_t j = 0; j < n; ++j) {
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t at = j * (n + 1) + i;
            triangles.push_back({at, at + 1, at + n + 2});
            triangles.push_back({at, at + n + 2, at + n + 1});
        }
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// No two triangles share a vertex.
TriangleMesh torn(const TriangleMesh& mesh)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        for (const Vec3& corner : mesh.triangle(TriangleId{i}).vertices)
            positions.push_back(corner);
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

TEST(MeshDeviation, OfOneTriangleThatIsCutThousandsOfTimes)
{
    constexpr std::uint32_t seed = 6;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const TriangleMesh sheet = torn(bumpy_sheet(seed));
    const TriangleMesh lid =
        mesh_of({Vec3(-0.9, -0.9, 1), Vec3(0.9, -0.9, 1), Vec3(0, 0.9, 1)}, {{0, 1, 2}});
    const auto found =
        greatest_deviation(build_mesh_index(lid).value(), build_mesh_index(sheet).value(),
                           {.tolerance = 1e-5, .max_splits = 20'000});
    ASSERT_TRUE(found) << describe(found.error());
    EXPECT_GT(found->splits, 1024U) << "more than are made in one go";
    EXPECT_TRUE(found->is_complete);
    EXPECT_LE(found->distance.upper - found->distance.lower, 1e-5);
    const double there = distance_from(sheet, found->point_a);
    EXPECT_GE(there, found->distance.lower - 1e-13);
    EXPECT_LE(there, found->distance.upper + 1e-13);
    visit_samples(lid, 24, [&](const Vec3& p) {
        EXPECT_LE(distance_from(sheet, p), found->distance.upper + 1e-13);
    });
    // Joined triangles lie along each other: far fewer cuts do, and both find the same distance.
    const auto joined =
        greatest_deviation(build_mesh_index(lid).value(),
                           build_mesh_index(bumpy_sheet(seed)).value(), {.tolerance = 1e-5});
    ASSERT_TRUE(joined) << describe(joined.error());
    EXPECT_LT(joined->splits, found->splits / 4);
    EXPECT_LE(joined->distance.lower, found->distance.upper);
    EXPECT_GE(joined->distance.upper, found->distance.lower);
}

TEST(MeshDeviation, OfParallelStripsIsTheirDistanceHoweverNarrowTheyAre)
{
    const MeshIndex floor = strip(1, -0.25);
    for (const double width : {1.0, 1e-3, 1e-6, 1e-9}) {
        SCOPED_TRACE(width); // the narrower, the more of the area may be rounding
        const auto found = mean_deviation(strip(width, 0.75), floor);
        ASSERT_TRUE(found) << describe(found.error());
        EXPECT_NEAR(found->area, 4 * width, found->area_error);
        for (const DistanceBounds& bounds : {found->mean, found->root_mean_square}) {
            EXPECT_LE(bounds.lower, 1);
            EXPECT_GE(bounds.upper, 1);
            EXPECT_LT(bounds.upper - bounds.lower, 1e-5 + 4 * found->area_error / found->area);
        }
    }
}

TEST(MeshDeviation, OfBodiesWhoseUnitsHaveNoSquaresForIt)
{
    // The farthest corner is 5 away, whatever is as small as that.
    const TriangleMesh large =
        mesh_of({Vec3(3, 4, 0), Vec3(-1, 0, 0), Vec3(0, -1, 1)}, {{0, 1, 2}});
    for (const double size : {1e-30, 1e-154, 1e-160, 1e-300, 1e-308, 1e-315, 5e-324}) {
        SCOPED_TRACE(::testing::Message() << "size " << size);
        const TriangleMesh small =
            mesh_of({Vec3(size, 0, 0), Vec3(0, size, 0), Vec3(0, 0, size), Vec3(size, size, 0)},
                    {{0, 1, 2}, {1, 2, 3}});
        const MeshIndex a = build_mesh_index(large).value();
        const MeshIndex b = build_mesh_index(small).value();
        const auto greatest = greatest_deviation(a, b, {.tolerance = 1e-6, .max_places = 4});
        ASSERT_TRUE(greatest) << describe(greatest.error());
        EXPECT_TRUE(greatest->is_complete);
        EXPECT_NEAR(greatest->distance.lower, 5, 1e-6);
        EXPECT_NEAR(greatest->distance.upper, 5, 1e-6);
        EXPECT_EQ(greatest->point_a, Vec3(3, 4, 0));
        ASSERT_EQ(greatest->places.size(), 1U);
        EXPECT_EQ(greatest->places[0].point_a, Vec3(3, 4, 0));
        const auto mean = mean_deviation(a, b, {.tolerance = 1e-3});
        ASSERT_TRUE(mean) << describe(mean.error());
        EXPECT_GT(mean->mean.lower, 1);
        EXPECT_LT(mean->mean.upper, 5);
        EXPECT_LE(mean->mean.upper - mean->mean.lower, 1e-3);
    }
}

TEST(MeshDeviation, HasHistogramsUpToTheirLimit)
{
    const MeshIndex low = strip(1, 0);
    const MeshIndex high = strip(1, 0.5);
    const auto found =
        mean_deviation(low, high, {.histogram_bins = max_histogram_bins, .histogram_end = 1});
    ASSERT_TRUE(found) << describe(found.error());
    ASSERT_EQ(found->histogram.size(), max_histogram_bins);
    EXPECT_NEAR(std::accumulate(found->histogram.begin(), found->histogram.end(), 0.0), 1, 1e-12);
    const auto more =
        mean_deviation(low, high, {.histogram_bins = max_histogram_bins + 1, .histogram_end = 1});
    ASSERT_FALSE(more);
    EXPECT_EQ(more.error().where, "histogram_bins");
}

TEST(MeshDeviation, SaysThatAllOfTheMeanIsDone)
{
    Progress progress;
    const auto found =
        mean_deviation(strip(1, 0), strip(1, 0.5), {.execution = {.progress = &progress}});
    ASSERT_TRUE(found);
    EXPECT_STREQ(progress.stage(), "mean deviation");
    EXPECT_EQ(progress.fraction(), 1);
}

} // namespace
} // namespace proxima::deviation_bounds_test
