// Means of deviations where their bounds can be told to the last bits, and what they report.
#include "index/test_meshes.h"
#include "proxima/mesh_deviation.h"
#include "proxima/mesh_index.h"

#include <gtest/gtest.h>
#include <numeric>

namespace proxima {
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
} // namespace proxima
