// Means from few large triangles to many small ones: bounds, tolerances and how the work is shared.
#include "code_of.h"
#include "geometry/closest_point.h"
#include "index/test_meshes.h"
#include "proxima/mesh_deviation.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "query/deviation/mean_search.h"
#include "query/deviation/sampled_deviation.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace proxima::large_triangles_test {
namespace {

using namespace testing;

MeshIndex large_index_of(const TriangleMesh& mesh)
{
    return build_mesh_index(mesh).value();
}

/// What says nothing of how the distance runs between samples: that it grows by no more than the way.
void expect_samples_agree(const SampledBounds& samples, const MeanDeviation& found)
{
    constexpr double slack = 1e-12;
    EXPECT_LE(found.mean.lower, samples.mean.upper / samples.area + slack);
    EXPECT_GE(found.mean.upper, samples.mean.lower / samples.area - slack);
    EXPECT_LE(found.root_mean_square.lower, std::sqrt(samples.square.upper / samples.area) + slack);
    EXPECT_GE(found.root_mean_square.upper, std::sqrt(samples.square.lower / samples.area) - slack);
}

TEST(LargeTriangles, MeansHoldThoseOfManySamples)
{
    const std::vector<Vec3> corners = {Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1.5, 0)};
    const TriangleMesh one = mesh_of(corners, {{0, 1, 2}});
    const TriangleMesh ball = sample_mesh("icosphere:3").value();
    for (const double height : {0.0, 0.3, 0.95, 3.0}) {
        SCOPED_TRACE(height);
        const TriangleMesh moved_one =
            moved(one, [&](const Vec3& p) { return Vec3(p + Vec3(0, 0, height)); });
        const MeshIndex a = large_index_of(moved_one);
        const MeshIndex b = large_index_of(ball);
        const MeanDeviation coarse = mean_deviation(a, b, {.tolerance = 1e-3}).value();
        const MeanDeviation fine = mean_deviation(a, b, {.tolerance = 2e-5}).value();
        const SampledBounds samples = sampled(moved_one, ball, 60);
        for (const MeanDeviation& found : {coarse, fine}) {
            EXPECT_TRUE(found.is_complete);
            expect_samples_agree(samples, found);
        }
        EXPECT_LE(coarse.mean.lower, fine.mean.upper);
        EXPECT_GE(coarse.mean.upper, fine.mean.lower);
        EXPECT_LE(coarse.root_mean_square.lower, fine.root_mean_square.upper);
        EXPECT_GE(coarse.root_mean_square.upper, fine.root_mean_square.lower);
    }
}

TEST(LargeTriangles, AreSharedAndKeepTheirBits)
{
    // The disk in the middle of a fine ball: some hundred triangles of it are as close to a point there.
    const MeshIndex a =
        large_index_of(mesh_of({Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1.5, 0)}, {{0, 1, 2}}));
    const MeshIndex b = large_index_of(sample_mesh("icosphere:4").value());
    const auto measure = [&](int threads, Progress* progress) {
        return mean_deviation(a, b,
                              {.tolerance = 1e-4,
                               .histogram_bins = 7,
                               .histogram_end = 1,
                               .execution = {.threads = {threads}, .progress = progress}});
    };
    // One triangle becomes parts enough for any number of threads: each group of them reports.
    Progress progress;
    progress.cancel_after(500);
    const auto cancelled = measure(1, &progress);
    ASSERT_FALSE(cancelled);
    EXPECT_EQ(code_of(cancelled), ErrorCode::cancelled);
    EXPECT_STREQ(progress.stage(), "parts of large triangles");
    const MeanDeviation one = measure(1, nullptr).value();
    EXPECT_TRUE(one.is_complete);
    EXPECT_NEAR(std::accumulate(one.histogram.begin(), one.histogram.end(), 0.0), 1, 1e-12);
    for (const int threads : {2, 5}) {
        const MeanDeviation many = measure(threads, nullptr).value();
        EXPECT_EQ(many.mean.lower, one.mean.lower);
        EXPECT_EQ(many.mean.upper, one.mean.upper);
        EXPECT_EQ(many.root_mean_square.lower, one.root_mean_square.lower);
        EXPECT_EQ(many.root_mean_square.upper, one.root_mean_square.upper);
        EXPECT_EQ(many.histogram, one.histogram);
        EXPECT_EQ(many.splits, one.splits);
        EXPECT_EQ(many.area, one.area);
    }
    // Few cuts: shared or not, what holds is held.
    for (const std::uint64_t most : {1U, 70U, 200U, 3000U}) {
        const MeanDeviation early =
            mean_deviation(a, b, {.tolerance = 1e-4, .max_splits = most}).value();
        EXPECT_FALSE(early.is_complete);
        EXPECT_LE(early.splits, std::max<std::uint64_t>(most, 64 * 16));
        EXPECT_LE(early.mean.lower, one.mean.upper);
        EXPECT_GE(early.mean.upper, one.mean.lower);
        EXPECT_NEAR(early.area, one.area, 1e-12);
    }
}

TEST(LargeTriangles, LeavePartsThatAddUp)
{
    const MeshIndex a =
        large_index_of(mesh_of({Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1.5, 0)}, {{0, 1, 2}}));
    const MeshIndex b = large_index_of(sample_mesh("icosphere:4").value());
    const SurfacePair pair = SurfacePair::make(a, b, {}).value();
    const MeasuredVertices vertices = measure_vertices(pair, {}).value();
    const auto search = [&](double spare) {
        return MeanSearch(pair, vertices,
                          {.tolerance = 1e-4,
                           .root = 0.4,
                           .spare = spare,
                           .most_splits = 1'000'000,
                           .bytes = MeanSearch::most_bytes},
                          nullptr);
    };
    const AreaHistogram empty(0, 0);
    MeanSums whole(empty);
    search(0).add_triangle(0, whole, nullptr);
    MeanSums shared(empty);
    std::vector<MeanPart> left;
    search(0).add_triangle(0, shared, &left);
    EXPECT_GE(left.size(), MeanSearch::parts_alone / 4);
    EXPECT_LE(left.size(), MeanSearch::most_left);
    EXPECT_LT(shared.splits, whole.splits / 8);
    double weight = 0;
    for (const MeanPart& part : left) {
        EXPECT_LE(part.part.weight, 0.125);
        weight += part.part.weight;
        search(0).add_part(part, shared, nullptr);
    }
    EXPECT_LE(weight, 1);
    EXPECT_EQ(shared.area.value(), whole.area.value());
    EXPECT_LE(shared.lower.value(), whole.upper.value());
    EXPECT_GE(shared.upper.value(), whole.lower.value());
    EXPECT_LE(shared.upper.value() - shared.lower.value(), 1e-4 * shared.area.value());
    // What others left makes for fewer cuts.
    MeanSums spared(empty);
    search(1e-3).add_triangle(0, spared, nullptr);
    EXPECT_LT(spared.splits, whole.splits);
}

TEST(LargeTriangles, LeaveFewPartsWhereThousandsAreStartedAnew)
{
    constexpr unsigned seed = 71;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-1, 1);
    std::vector<Vec3> points;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < 200; ++i) {
        const Vec3 middle(place(random), place(random), place(random));
        for (int k = 0; k < 3; ++k)
            points.emplace_back(middle + 0.2 * Vec3(place(random), place(random), place(random)));
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const MeshIndex a = large_index_of(
        mesh_of({Vec3(-1, -1, 0.1), Vec3(1, -1, -0.2), Vec3(0, 1, 0.3)}, {{0, 1, 2}}));
    const MeshIndex b = large_index_of(mesh_of(points, triangles));
    const SurfacePair pair = SurfacePair::make(a, b, {}).value();
    const MeasuredVertices vertices = measure_vertices(pair, {}).value();
    MeanSearch search(pair, vertices,
                      {.tolerance = 1e-4,
                       .root = 0.3,
                       .spare = 0,
                       .most_splits = 1U << 20U,
                       .bytes = MeanSearch::most_bytes},
                      nullptr);
    MeanSums sums(AreaHistogram(0, 0));
    std::vector<MeanPart> left;
    search.add_triangle(0, sums, &left);
    EXPECT_EQ(left.size(), MeanSearch::most_left) << "seed " << seed;
    EXPECT_GT(sums.splits, 20'000U); // what did not go there was looked at
}

/// The plane z = 0 from a ring of so large a radius outward.
TriangleMesh plane_with_hole(double radius)
{
    constexpr std::uint32_t count = 24;
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / count;
        const Vec3 out(std::cos(angle), std::sin(angle), 0);
        positions.emplace_back(radius * out);
        positions.emplace_back(9 * out);
        const std::uint32_t next = 2 * ((i + 1) % count);
        triangles.push_back({2 * i, 2 * i + 1, next + 1});
        triangles.push_back({2 * i, next + 1, next});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

TEST(LargeTriangles, RootMeanSquareReachesItsToleranceWhereSamplesMislead)
{
    // Only the middle of the triangle is away from the plane, so its centroid says far too much.
    const TriangleMesh one = mesh_of({Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 2, 0)}, {{0, 1, 2}});
    for (const double radius : {0.1, 0.03}) {
        const TriangleMesh plane = plane_with_hole(radius);
        const MeshIndex a = large_index_of(one);
        const MeshIndex b = large_index_of(plane);
        // Of each of the hole's 24 sectors, of height h, the points at x along it are h - x away.
        const double h = radius * std::cos(std::numbers::pi / 24);
        const double sectors = 24 * std::tan(std::numbers::pi / 24);
        constexpr double area = 3;
        const double mean = sectors * std::pow(h, 3) / 3 / area;
        const double root = std::sqrt(sectors * std::pow(h, 4) / 6 / area);
        for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6}) {
            SCOPED_TRACE(std::to_string(radius) + ", " + std::to_string(tolerance));
            const MeanDeviation found = mean_deviation(a, b, {.tolerance = tolerance}).value();
            EXPECT_TRUE(found.is_complete);
            EXPECT_LE(found.mean.upper - found.mean.lower, tolerance);
            EXPECT_LE(found.root_mean_square.upper - found.root_mean_square.lower, tolerance);
            EXPECT_LE(found.mean.lower, mean);
            EXPECT_GE(found.mean.upper, mean);
            EXPECT_LE(found.root_mean_square.lower, root);
            EXPECT_GE(found.root_mean_square.upper, root);
        }
    }
}

TEST(LargeTriangles, MeansByCornersAloneAreBelowThoseOfAnySet)
{
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto point = [&] { return Vec3(unit(random), unit(random), unit(random)); };
    int useful = 0;
    for (int round = 0; round < 300; ++round) {
        SCOPED_TRACE(round);
        const double size = std::pow(10.0, unit(random));
        const std::array<Vec3, 3> corners = {Vec3(size * point()), Vec3(size * point()),
                                             Vec3(size * point())};
        std::vector<Vec3> set;
        for (int i = 0; i < 1 + round % 4; ++i) set.push_back(2 * point());
        const auto distance = [&](const Vec3& p) {
            double least = HUGE_VAL;
            for (const Vec3& q : set) least = std::min(least, (p - q).norm());
            return least;
        };
        constexpr int cuts = 60;
        double mean = 0;
        double squares = 0;
        double all = 0;
        // The centroids of small triangles: the square between them is at most a small triangle's more.
        visit_small_triangles(mesh_of({corners.begin(), corners.end()}, {{0, 1, 2}}), cuts,
                              [&](const Vec3& p, const Vec3& q, const Vec3& r) {
                                  const double d = distance((p + q + r) / 3);
                                  mean += d;
                                  squares += d * d;
                                  ++all;
                              });
        const double sides = (corners[0] - corners[1]).squaredNorm() +
                             (corners[1] - corners[2]).squaredNorm() +
                             (corners[2] - corners[0]).squaredNorm();
        const double error = sides / (cuts * cuts);
        const MeanBounds lower = lower_means(
            corners, {distance(corners[0]), distance(corners[1]), distance(corners[2])}, 1e-14);
        EXPECT_LE(lower.lower, mean / all + std::sqrt(error) / cuts);
        EXPECT_LE(lower.squares_lower, squares / all + error);
        if (lower.lower > 0.9 * mean / all) ++useful;
    }
    EXPECT_GT(useful, 30);
}

} // namespace
} // namespace proxima::large_triangles_test
