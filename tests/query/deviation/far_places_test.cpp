// Places that are as far as any, and means of both directions.
#include "index/test_meshes.h"
#include "proxima/mesh_deviation.h"
#include "proxima/sample_meshes.h"
#include "query/deviation/sampled_deviation.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

namespace proxima::far_places_test {
namespace {

using namespace testing;

MeshIndex index_of(const TriangleMesh& mesh)
{
    return build_mesh_index(mesh).value();
}

GreatestDeviation places_of(const TriangleMesh& a, const TriangleMesh& b,
                            const GreatestDeviationOptions& options)
{
    return greatest_deviation(index_of(a), index_of(b), options).value();
}

double nearest_place(const GreatestDeviation& found, const Vec3& p)
{
    double least = HUGE_VAL;
    for (const FarPlace& place : found.places) least = std::min(least, (place.point_a - p).norm());
    return least;
}

/// Places are far, apart and, with samples, near all that is far. Adds up the samples that are.
void expect_places(const TriangleMesh& a, const TriangleMesh& b, double tolerance, double spacing,
                   int cuts, std::size_t& as_far)
{
    const GreatestDeviation found =
        places_of(a, b, {.tolerance = tolerance, .max_places = 256, .place_spacing = spacing});
    ASSERT_FALSE(found.places.empty());
    EXPECT_TRUE(found.is_complete);
    EXPECT_TRUE(found.has_all_places);
    constexpr double slack = 1e-12;
    EXPECT_EQ(found.places[0].point_a, found.point_a);
    for (std::size_t i = 0; i < found.places.size(); ++i) {
        const FarPlace& place = found.places[i];
        EXPECT_NEAR(distance_from(b, place.point_a), place.distance, slack);
        EXPECT_NEAR((place.point_a - place.point_b).norm(), place.distance, slack);
        EXPECT_GE(place.distance, found.distance.lower - tolerance - slack);
        EXPECT_LE(place.distance, found.distance.upper);
        EXPECT_LE((closest_point(a.triangle(place.triangle_a), place.point_a).point - place.point_a)
                      .norm(),
                  slack);
        for (std::size_t j = 0; j < i; ++j) {
            EXPECT_GT((place.point_a - found.places[j].point_a).norm(), spacing - slack);
            EXPECT_LE(place.distance, found.places[j].distance);
        }
    }
    visit_samples(a, cuts, [&](const Vec3& p) {
        if (!(distance_from(b, p) >= found.distance.lower)) return;
        ++as_far;
        EXPECT_LE(nearest_place(found, p), 3 * spacing + slack) << p.transpose();
    });
}

TEST(FarPlaces, AreAllCornersOfACube)
{
    const TriangleMesh inner = cube_mesh(Vec3::Zero(), 1);
    const TriangleMesh outer = cube_mesh(Vec3::Zero(), 1.5);
    const GreatestDeviation found =
        places_of(outer, inner, {.max_places = 100, .place_spacing = 0.1});
    EXPECT_TRUE(found.has_all_places);
    ASSERT_EQ(found.places.size(), 8U);
    for (const FarPlace& place : found.places) {
        EXPECT_EQ(place.point_a.cwiseAbs(), Vec3(1.5, 1.5, 1.5));
        EXPECT_NEAR(place.distance, 0.5 * std::sqrt(3.0), 1e-15);
        EXPECT_NEAR((place.point_b - place.point_a / 1.5).norm(), 0, 1e-15);
    }
    // Not more than was asked for, and it says so.
    const GreatestDeviation few = places_of(outer, inner, {.max_places = 3});
    EXPECT_EQ(few.places.size(), 3U);
    EXPECT_FALSE(few.has_all_places);
    EXPECT_TRUE(places_of(outer, inner, {}).places.empty());
    // Where nothing is far, no place is missing.
    const GreatestDeviation none = places_of(outer, outer, {.max_places = 3});
    EXPECT_TRUE(none.places.empty());
    EXPECT_TRUE(none.has_all_places);
}

TEST(FarPlaces, AreInTheInsideOfTriangles)
{
    const TriangleMesh floor =
        mesh_of({Vec3(-9, -9, 0), Vec3(9, -9, 0), Vec3(0, 9, 0)}, {{0, 1, 2}});
    const TriangleMesh walls = mesh_of({Vec3(-1, -9, -9), Vec3(-1, 9, -9), Vec3(-1, 0, 9),
                                        Vec3(1, -9, -9), Vec3(1, 9, -9), Vec3(1, 0, 9)},
                                       {{0, 1, 2}, {3, 4, 5}});
    // Between two walls all points of the middle line are as far.
    const TriangleMesh between =
        mesh_of({Vec3(-0.9, 0, 0), Vec3(0.7, 0.1, 0), Vec3(0.8, -0.2, 0.3)}, {{0, 1, 2}});
    std::size_t as_far = 0;
    expect_places(between, walls, 1e-6, 0.02, 300, as_far);
    expect_places(floor, walls, 1e-4, 0.5, 60, as_far);
    EXPECT_GT(as_far, 50U);
}

TEST(FarPlaces, AreAllThatSamplesFind)
{
    // A ring of places, and surfaces that are about as far everywhere.
    const TriangleMesh torus = sample_mesh("torus:24x12").value();
    std::size_t as_far = 0;
    expect_places(moved(torus, [](const Vec3& p) { return Vec3(1.25 * p); }), torus, 1e-3, 0.2, 4,
                  as_far);
    expect_places(sphere_mesh(Vec3::Zero(), 1.1, 8, 12), sphere_mesh(Vec3::Zero(), 1, 8, 12), 1e-2,
                  0.3, 6, as_far);
    EXPECT_GT(as_far, 100U);
    as_far = 0;
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        expect_places(grid_mesh(seed), grid_mesh(seed + 50), 0.05, 0.5, 10, as_far);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(as_far, 100U);
}

TEST(FarPlaces, HaveTheSameBitsForAnyNumberOfThreads)
{
    const MeshIndex a = index_of(sample_mesh("torus:60x30").value());
    const MeshIndex b = index_of(
        moved(sample_mesh("torus:50x31").value(), [](const Vec3& p) { return Vec3(1.01 * p); }));
    const auto found = [&](int threads) {
        return greatest_deviation(
                   a, b,
                   {.tolerance = 1e-3, .max_places = 256, .execution = {.threads = {threads}}})
            .value();
    };
    const GreatestDeviation one = found(1);
    EXPECT_GT(one.places.size(), 10U);
    for (const int threads : {2, 5}) {
        const GreatestDeviation many = found(threads);
        ASSERT_EQ(one.places.size(), many.places.size());
        EXPECT_EQ(one.has_all_places, many.has_all_places);
        EXPECT_EQ(one.splits, many.splits);
        for (std::size_t i = 0; i < one.places.size(); ++i) {
            EXPECT_EQ(one.places[i].point_a, many.places[i].point_a);
            EXPECT_EQ(one.places[i].point_b, many.places[i].point_b);
            EXPECT_EQ(one.places[i].distance, many.places[i].distance);
        }
    }
}

TEST(TwoSidedMean, CountsBothSurfacesByArea)
{
    // Bounds of each way by samples, added up by area, meet those of both.
    int compared = 0;
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const TriangleMesh a = grid_mesh(seed);
        const TriangleMesh b = grid_mesh(seed + 100);
        const auto there_or_not = mean_deviation(index_of(a), index_of(b));
        const auto back_or_not = mean_deviation(index_of(b), index_of(a));
        if (!there_or_not || !back_or_not) continue; // a mesh without area
        ++compared;
        const MeanDeviation& there = *there_or_not;
        const MeanDeviation& back = *back_or_not;
        const TwoSidedMean both = both_ways(there, back);
        const SampledBounds one = sampled(a, b, 12);
        const SampledBounds other = sampled(b, a, 12);
        const double area = one.area + other.area;
        EXPECT_LE(both.mean.lower, (one.mean.upper + other.mean.upper) / area);
        EXPECT_GE(both.mean.upper, (one.mean.lower + other.mean.lower) / area);
        EXPECT_LE(both.root_mean_square.lower,
                  std::sqrt((one.square.upper + other.square.upper) / area));
        EXPECT_GE(both.root_mean_square.upper,
                  std::sqrt((one.square.lower + other.square.lower) / area));
        EXPECT_LT(both.mean.upper - both.mean.lower, 1e-4 * size_of(a, b));
        EXPECT_EQ(both.larger_mean.lower, std::max(there.mean.lower, back.mean.lower));
        EXPECT_EQ(both.larger_mean.upper, std::max(there.mean.upper, back.mean.upper));
        EXPECT_EQ(both.larger_root_mean_square.upper,
                  std::max(there.root_mean_square.upper, back.root_mean_square.upper));
        // The other way round it is the same.
        EXPECT_NEAR(both_ways(back, there).mean.lower, both.mean.lower, 1e-14 * size_of(a, b));
    }
    EXPECT_GE(compared, 5);
}

/// All of the area at one distance.
MeanDeviation one_way(double distance, double area, double error)
{
    return {.mean = {distance, distance},
            .root_mean_square = {distance, distance},
            .area = area,
            .area_error = error,
            .histogram = {}};
}

TEST(TwoSidedMean, IsHonestWhereAreasAreNot)
{
    const TwoSidedMean sure = both_ways(one_way(1, 1, 0), one_way(4, 2, 0));
    EXPECT_LE(sure.mean.lower, 3);
    EXPECT_GE(sure.mean.upper, 3);
    EXPECT_NEAR(sure.mean.lower, sure.mean.upper, 1e-12);
    EXPECT_LE(sure.root_mean_square.lower, std::sqrt(11.0));
    EXPECT_GE(sure.root_mean_square.upper, std::sqrt(11.0));
    EXPECT_NEAR(sure.root_mean_square.lower, sure.root_mean_square.upper, 1e-12);
    // From a third to a half of both.
    const TwoSidedMean doubtful = both_ways(one_way(1, 1, 0.2), one_way(4, 1.8, 0.6));
    EXPECT_LE(doubtful.mean.lower, 2.5);
    EXPECT_GE(doubtful.mean.upper, 3);
    for (const double area : {0.0, HUGE_VAL}) {
        const TwoSidedMean unknown = both_ways(one_way(1, area, 0), one_way(4, area, 0));
        EXPECT_LE(unknown.mean.lower, 1);
        EXPECT_GE(unknown.mean.upper, 4);
    }
    const TwoSidedMean huge = both_ways(one_way(1e300, 1, 0), one_way(3e300, 1, 0));
    EXPECT_NEAR(huge.root_mean_square.upper, std::sqrt(5.0) * 1e300, 1e290);
    const TwoSidedMean none = both_ways(one_way(0, 1, 0), one_way(0, 1, 0));
    EXPECT_LT(none.mean.upper, 1e-300);
    EXPECT_EQ(none.root_mean_square.upper, 0);
}

TEST(TwoSidedMean, CountsAreasAtTheEndsOfTheDoubles)
{
    // At the lower end the areas are about the least double. At the upper end they are doubles, but their
    // sum, or the sum of one and its error, is none.
    for (const double s :
         {1.2e-162, 2.4e-162, 3.3e-162, 1e-160, 1.0, 1.3e154, 1.5e154, 1.7929e154, 2e154}) {
        SCOPED_TRACE(s);
        const MeshIndex a =
            index_of(mesh_of({Vec3(0, 0, 0), Vec3(s, 0, 0), Vec3(0, s, 0)}, {{0, 1, 2}}));
        const MeshIndex b = index_of(
            mesh_of({Vec3(0, 0, 0.5 * s), Vec3(s, 0, 0.5 * s), Vec3(0, s, s)}, {{0, 1, 2}}));
        const auto there = mean_deviation(a, b);
        const auto back = mean_deviation(b, a);
        ASSERT_TRUE(there) << describe(there.error());
        ASSERT_TRUE(back) << describe(back.error());
        const long double square = static_cast<long double>(s) * s;
        const long double slope = std::sqrt(1.25L); // by which B's area is larger
        EXPECT_LE(std::abs(there->area - 0.5L * square), there->area_error);
        EXPECT_LE(std::abs(back->area - 0.5L * slope * square), back->area_error);
        const auto share = static_cast<double>(1 / (1 + slope));
        const TwoSidedMean both = both_ways(*there, *back);
        const auto mixed = [&](double of_a, double of_b) {
            return share * of_a + (1 - share) * of_b;
        };
        EXPECT_LE(both.mean.lower, mixed(there->mean.upper, back->mean.upper));
        EXPECT_GE(both.mean.upper, mixed(there->mean.lower, back->mean.lower));
        const double width = both.mean.upper - both.mean.lower;
        if (s > 1e-161 && s < 1.8e154) {
            EXPECT_LT(width, 1e-3 * s);
        }
    }
}

TEST(TwoSidedMean, AddsUpAreasWhoseSumIsNoDouble)
{
    constexpr double most = std::numeric_limits<double>::max();
    const TwoSidedMean equal = both_ways(one_way(1, most, 0), one_way(4, most, 0));
    EXPECT_NEAR(equal.mean.lower, 2.5, 1e-12);
    EXPECT_NEAR(equal.mean.upper, 2.5, 1e-12);
    // From a third to two thirds of both.
    const TwoSidedMean doubtful =
        both_ways(one_way(1, 0.75 * most, 0.25 * most), one_way(4, 0.75 * most, 0.25 * most));
    EXPECT_NEAR(doubtful.mean.lower, 2, 1e-12);
    EXPECT_NEAR(doubtful.mean.upper, 3, 1e-12);
    // Nothing is known of a share where an area is infinite.
    for (const double error : {0.0, 1e300, HUGE_VAL}) {
        const TwoSidedMean unknown = both_ways(one_way(1, 1e308, 0), one_way(4, HUGE_VAL, error));
        EXPECT_LE(unknown.mean.lower, 1);
        EXPECT_GE(unknown.mean.upper, 4);
    }
}

TEST(MeanDeviation, HasAreasOfTrianglesWhoseSquaresAreBelowTheDoubles)
{
    const MeshIndex large =
        index_of(mesh_of({Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(1, 1, 0)}, {{0, 1, 2}}));
    for (const double s : {1.23e-80, 2.9e-81, 1.7e-79, 3.1e-75}) {
        SCOPED_TRACE(s);
        const MeshIndex small =
            index_of(mesh_of({Vec3(0, 0, 0), Vec3(s, 0, 0), Vec3(0, s, 0), Vec3(0, 0, 0.3 * s)},
                             {{0, 1, 2}, {0, 2, 3}}));
        const auto found = mean_deviation(small, large);
        ASSERT_TRUE(found) << describe(found.error());
        const long double area = 0.65L * s * s;
        EXPECT_LE(std::abs(found->area - area), found->area_error);
        EXPECT_LE(found->mean.lower, 1);
        EXPECT_GE(found->mean.upper, 1);
    }
}

} // namespace
} // namespace proxima::far_places_test
