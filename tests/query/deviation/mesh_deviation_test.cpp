#include "proxima/mesh_deviation.h"

#include "cancellation.h"
#include "code_of.h"
#include "geometry/closest_point.h"
#include "index/test_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "query/deviation/sampled_deviation.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <string>
#include <vector>

namespace proxima::mesh_deviation_test {
namespace {

using namespace testing;

MeshIndex index_of(const TriangleMesh& mesh)
{
    return build_mesh_index(mesh).value();
}

GreatestDeviation greatest_of(const TriangleMesh& a, const TriangleMesh& b,
                              const GreatestDeviationOptions& options = {})
{
    return greatest_deviation(index_of(a), index_of(b), options).value();
}

MeanDeviation mean_of(const TriangleMesh& a, const TriangleMesh& b,
                      const MeanDeviationOptions& options = {})
{
    return mean_deviation(index_of(a), index_of(b), options).value();
}

void expect_meets(const DistanceBounds& bounds, double lower, double upper, double slack)
{
    EXPECT_LE(bounds.lower, bounds.upper);
    EXPECT_GE(bounds.lower, 0);
    EXPECT_LE(bounds.lower, upper + slack);
    EXPECT_GE(bounds.upper, lower - slack);
}

/// Bounds hold what samples prove, and are as near to each other as they say.
void expect_bounds(const TriangleMesh& a, const TriangleMesh& b, int cuts)
{
    const double size = size_of(a, b);
    const double slack = 1e-13 * size;
    const SampledBounds samples = sampled(a, b, cuts);
    const GreatestDeviation greatest = greatest_of(a, b, {.tolerance = 1e-7 * size});
    EXPECT_TRUE(greatest.is_complete) << greatest.distance.upper - greatest.distance.lower;
    EXPECT_LE(greatest.distance.upper - greatest.distance.lower, 1e-7 * size);
    expect_meets(greatest.distance, samples.greatest.lower, samples.greatest.upper, slack);
    // The point is on A, and as far from B as it says.
    const double there = distance_from(b, greatest.point_a);
    EXPECT_GE(there, greatest.distance.lower - slack);
    EXPECT_LE(there, greatest.distance.upper + slack);
    EXPECT_LE(
        (closest_point(a.triangle(greatest.triangle_a), greatest.point_a).point - greatest.point_a)
            .norm(),
        slack);
    EXPECT_NEAR((greatest.point_a - greatest.point_b).norm(), there, slack);
    EXPECT_LE(
        (closest_point(b.triangle(greatest.triangle_b), greatest.point_b).point - greatest.point_b)
            .norm(),
        slack);
    // Coarser bounds hold finer ones' number as well.
    for (const double tolerance : {1e-3 * size, 0.1 * size}) {
        const DistanceBounds coarse = greatest_of(a, b, {.tolerance = tolerance}).distance;
        EXPECT_LE(coarse.lower, greatest.distance.upper);
        EXPECT_GE(coarse.upper, greatest.distance.lower);
    }
    if (!(samples.area > 0)) return;
    std::vector<MeanDeviation> means;
    for (const double tolerance : {1e-3 * size, 1e-4 * size}) {
        means.push_back(mean_of(a, b, {.tolerance = tolerance}));
        const MeanDeviation& mean = means.back();
        EXPECT_TRUE(mean.is_complete) << mean.mean.upper - mean.mean.lower;
        EXPECT_NEAR(mean.area, samples.area, 1e-10 * size * size);
        expect_meets(mean.mean, samples.mean.lower / samples.area,
                     samples.mean.upper / samples.area, slack);
        expect_meets(mean.root_mean_square, std::sqrt(samples.square.lower / samples.area),
                     std::sqrt(samples.square.upper / samples.area), slack);
        // Means are in this order, and below the greatest distance.
        EXPECT_LE(mean.mean.lower, mean.root_mean_square.upper);
        EXPECT_LE(mean.root_mean_square.lower, greatest.distance.upper);
    }
    expect_meets(means[0].mean, means[1].mean.lower, means[1].mean.upper, slack);
    expect_meets(means[0].root_mean_square, means[1].root_mean_square.lower,
                 means[1].root_mean_square.upper, slack);
}

/// A square of n x n cells in the plane z = height, over [-half, half]^2.
TriangleMesh sheet(std::uint32_t n, double half, double height)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t j = 0; j <= n; ++j) {
        for (std::uint32_t i = 0; i <= n; ++i)
            positions.emplace_back(half * (2.0 * i / n - 1), half * (2.0 * j / n - 1), height);
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

TriangleMesh soup(std::mt19937_64& random, int count, double triangle_size)
{
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (int i = 0; i < count; ++i) {
        const Vec3 middle(unit(random), unit(random), unit(random));
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (int k = 0; k < 3; ++k) {
            positions.emplace_back(middle +
                                   triangle_size * Vec3(unit(random), unit(random), unit(random)));
        }
        triangles.push_back({first, first + 1, first + 2});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

TEST(MeshDeviation, HoldsWhatSamplesProveOnSoups)
{
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937_64 random(seed);
        const TriangleMesh a = soup(random, 1 + static_cast<int>(seed), 0.7);
        const TriangleMesh b = soup(random, 20, seed % 2 == 0 ? 0.2 : 1.0);
        expect_bounds(a, b, 24);
    }
}

TEST(MeshDeviation, HoldsWhatSamplesProveOnBrokenMeshes)
{
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        expect_bounds(grid_mesh(seed), grid_mesh(seed + 100), 12);
    }
    const TriangleMesh sphere = sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 8, 10);
    for (const NamedMesh& named :
         {NamedMesh{"slivers", sliver_strip()}, NamedMesh{"fans", fans()},
          NamedMesh{"cube", cube_mesh(Vec3::Zero(), 1.0)},
          NamedMesh{"open", without(sphere, [](std::size_t i) { return i % 5 == 0; })},
          NamedMesh{"a point", mesh_of({Vec3(0.1, 0.2, 0.3)}, {{0, 0, 0}})},
          NamedMesh{"a segment", mesh_of({Vec3(0, 0, 0), Vec3(1, 2, 3)}, {{0, 1, 1}})}}) {
        SCOPED_TRACE(named.name);
        expect_bounds(named.mesh, sphere, 6);
        expect_bounds(sphere, named.mesh, 6);
    }
    expect_bounds(moved(sphere, [](const Vec3& p) { return Vec3(p + Vec3(1e6, -1e6, 1e6)); }),
                  moved(sphere, [](const Vec3& p) { return Vec3(p + Vec3(1e6 + 0.1, -1e6, 1e6)); }),
                  4);
}

TEST(MeshDeviation, HoldsWhatIsCloseToCornersAlone)
{
    // From the middle to the corners the distance grows, and there something else is closer, which is farther
    // from the middle than the corners are.
    const std::array<Vec3, 3> corners = {Vec3(2, 0, 0), Vec3(-1, 1.75, 0), Vec3(-1, -1.75, 0)};
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (const Vec3& place :
         {Vec3(0, 0, 0), Vec3(1.3 * corners[0]), Vec3(1.3 * corners[1]), Vec3(1.3 * corners[2])}) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (const Vec3& corner : corners) positions.emplace_back(place + 0.01 * corner);
        triangles.push_back({first, first + 1, first + 2});
    }
    expect_bounds(mesh_of({corners.begin(), corners.end()}, {{0, 1, 2}}),
                  mesh_of(std::move(positions), std::move(triangles)), 100);
}

TEST(MeshDeviation, HeedsTrianglesThatAreHardlyCloser)
{
    // Two planes that cross below a square, with slopes +e and -e: the distance is (1 - e |x|) / sqrt(1 + e^2).
    for (const double e : {1e-7, 1e-6, 1.5e-6, 1e-5, 1e-3}) {
        SCOPED_TRACE(e);
        const auto sloped = [](double slope) {
            return moved(sheet(1, 9, 0),
                         [&](const Vec3& p) { return Vec3(p.x(), p.y(), slope * p.x() - 1); });
        };
        const MeanDeviation mean =
            mean_of(sheet(1, 1, 0), joined(sloped(e), sloped(-e)), {.tolerance = 1e-3});
        const double truth = (1 - 0.5 * e) / std::sqrt(1 + e * e);
        EXPECT_LE(mean.mean.lower, truth);
        EXPECT_GE(mean.mean.upper, truth);
        const double root = std::sqrt((1 - e + e * e / 3) / (1 + e * e));
        EXPECT_LE(mean.root_mean_square.lower, root);
        EXPECT_GE(mean.root_mean_square.upper, root);
    }
}

TEST(MeshDeviation, IsZeroForTheSameTriangles)
{
    // An edge of the second triangle passes through the middle of the first.
    const TriangleMesh pierced = mesh_of(
        {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 3, 0), Vec3(1, 1, -1), Vec3(1, 1, 1), Vec3(5, 5, 1)},
        {{0, 1, 2}, {3, 4, 5}});
    for (const TriangleMesh& mesh :
         {sample_mesh("icosphere:3").value(), fans(), sliver_strip(), pierced}) {
        std::vector<TriangleCorners> turned(mesh.triangles().rbegin(), mesh.triangles().rend());
        for (TriangleCorners& corners : turned) corners = {corners[2], corners[1], corners[0]};
        const TriangleMesh other =
            mesh_of({mesh.positions().begin(), mesh.positions().end()}, turned);
        const GreatestDeviation same = greatest_of(mesh, other);
        EXPECT_EQ(same.distance.lower, 0);
        EXPECT_EQ(same.distance.upper, 0);
        EXPECT_TRUE(same.is_complete);
        EXPECT_LE(mean_of(mesh, other).mean.upper, 1e-5 * size_of(mesh, mesh));
        // A part of it is not farther; the whole from the part is.
        const TriangleMesh part = without(mesh, [](std::size_t i) { return i == 0; });
        EXPECT_EQ(greatest_of(part, mesh).distance.upper, 0);
        EXPECT_GT(greatest_of(mesh, part).distance.upper, 0);
    }
}

TEST(MeshDeviation, IsThatOfSheets)
{
    // The same plane cut into other triangles.
    const GreatestDeviation flat = greatest_of(sheet(7, 1, 0), sheet(11, 1.5, 0));
    EXPECT_EQ(flat.distance.lower, 0);
    EXPECT_LT(flat.distance.upper, 5e-6);
    EXPECT_TRUE(flat.is_complete);
    EXPECT_LT(mean_of(sheet(7, 1, 0), sheet(11, 1.5, 0)).mean.upper, 5e-5);
    // Parallel ones.
    const TriangleMesh above = sheet(7, 1, 0.25);
    const TriangleMesh below = sheet(12, 2, 0);
    const GreatestDeviation parallel = greatest_of(above, below);
    EXPECT_NEAR(parallel.distance.lower, 0.25, 5e-6);
    EXPECT_LE(parallel.distance.lower, 0.25);
    EXPECT_GE(parallel.distance.upper, 0.25);
    const MeanDeviation mean = mean_of(above, below);
    EXPECT_LE(mean.mean.lower, 0.25);
    EXPECT_GE(mean.mean.upper, 0.25);
    EXPECT_LE(mean.root_mean_square.lower, 0.25);
    EXPECT_GE(mean.root_mean_square.upper, 0.25);
    EXPECT_NEAR(mean.mean.lower, 0.25, 1e-4);
    // Back, the farthest points are the corners of the larger one.
    const double corner = std::hypot(std::hypot(1, 1), 0.25);
    const DistanceBounds back = greatest_of(below, above).distance;
    EXPECT_LE(back.lower, corner);
    EXPECT_GE(back.upper, corner);
    EXPECT_NEAR(back.lower, corner, 1e-5);
}

TEST(MeshDeviation, HasTheMeansOfARamp)
{
    // z = x over [-1, 1]^2: distances |x| from the plane below it.
    const TriangleMesh ramp =
        moved(sheet(3, 1, 0), [](const Vec3& p) { return Vec3(p.x(), p.y(), p.x()); });
    const MeanDeviation mean =
        mean_of(ramp, sheet(1, 9, 0), {.tolerance = 1e-4, .histogram_bins = 4, .histogram_end = 1});
    EXPECT_TRUE(mean.is_complete);
    EXPECT_LE(mean.mean.lower, 0.5);
    EXPECT_GE(mean.mean.upper, 0.5);
    EXPECT_NEAR(mean.mean.lower, 0.5, 1e-4);
    EXPECT_LE(mean.root_mean_square.lower, 1 / std::sqrt(3.0));
    EXPECT_GE(mean.root_mean_square.upper, 1 / std::sqrt(3.0));
    EXPECT_NEAR(mean.root_mean_square.upper, 1 / std::sqrt(3.0), 1e-4);
    EXPECT_NEAR(mean.area, 4 * std::sqrt(2.0), 1e-12);
    ASSERT_EQ(mean.histogram.size(), 4U);
    for (const double share : mean.histogram) EXPECT_NEAR(share, 0.25, 1e-3);
    const auto all = mean_of(ramp, sheet(1, 9, 0), {.histogram_bins = 3, .histogram_end = 0.25});
    EXPECT_NEAR(std::accumulate(all.histogram.begin(), all.histogram.end(), 0.0), 1, 1e-12);
    EXPECT_NEAR(all.histogram[2], 1 - 2 * 0.25 / 3, 1e-3);
}

TEST(MeshDeviation, IsThatOfPolyhedra)
{
    // A vertex of the larger sphere is above its own image, which is the support in its direction.
    const TriangleMesh ball = sample_mesh("icosphere:3").value();
    const TriangleMesh larger = moved(ball, [](const Vec3& p) { return Vec3(1.25 * p); });
    const DistanceBounds outward = greatest_of(larger, ball).distance;
    EXPECT_NEAR(outward.lower, 0.25, 1e-12);
    EXPECT_NEAR(outward.upper, 0.25, 1e-12);
    EXPECT_LE(greatest_of(ball, larger).distance.upper, 0.25 + 1e-12);
    // A corner of a cube that was moved away from it is closest to the same corner.
    const Vec3 shift(0.1, 0.2, 0.3);
    const DistanceBounds cubes =
        greatest_of(cube_mesh(Vec3::Zero(), 1), cube_mesh(shift, 1)).distance;
    EXPECT_LE(cubes.lower, shift.norm() + 1e-12);
    EXPECT_GE(cubes.upper, shift.norm() - 1e-12);
    EXPECT_LT(cubes.upper - cubes.lower, 5e-6);
    // The middle of a cube's face from a needle through its centre is not a vertex of either.
    const TriangleMesh axis = mesh_of({Vec3(-5, 0, 0), Vec3(5, 0, 0)}, {{0, 1, 1}});
    const GreatestDeviation face = greatest_of(sheet(1, 1, 0), axis);
    EXPECT_NEAR(face.distance.lower, 1, 1e-12);
    // Between two parallel walls the farthest points are in the middle.
    const TriangleMesh walls = mesh_of({Vec3(-1, -9, -9), Vec3(-1, 9, -9), Vec3(-1, 0, 9),
                                        Vec3(1, -9, -9), Vec3(1, 9, -9), Vec3(1, 0, 9)},
                                       {{0, 1, 2}, {3, 4, 5}});
    const TriangleMesh between =
        mesh_of({Vec3(-0.9, 0, 0), Vec3(0.7, 0.1, 0), Vec3(0.8, -0.2, 0.3)}, {{0, 1, 2}});
    const GreatestDeviation middle = greatest_of(between, walls);
    EXPECT_NEAR(middle.distance.lower, 1, 1e-5);
    EXPECT_LE(middle.distance.lower, 1);
    EXPECT_GE(middle.distance.upper, 1);
    EXPECT_NEAR(middle.point_a.x(), 0, 1e-5);
}

TEST(MeshDeviation, HasTheSameBitsForAnyNumberOfThreads)
{
    const MeshIndex a = index_of(sample_mesh("torus:60x30").value());
    const MeshIndex b = index_of(moved(sample_mesh("torus:50x31").value(),
                                       [](const Vec3& p) { return Vec3(p + Vec3(0.01, 0, 0)); }));
    const auto greatest = [&](int threads) {
        return greatest_deviation(a, b, {.execution = {.threads = {threads}}}).value();
    };
    const auto mean = [&](int threads) {
        return mean_deviation(a, b,
                              {.tolerance = 1e-3,
                               .histogram_bins = 9,
                               .histogram_end = 0.02,
                               .execution = {.threads = {threads}}})
            .value();
    };
    const GreatestDeviation one = greatest(1);
    const MeanDeviation mean_one = mean(1);
    for (const int threads : {2, 5}) {
        const GreatestDeviation many = greatest(threads);
        EXPECT_EQ(one.distance.lower, many.distance.lower);
        EXPECT_EQ(one.distance.upper, many.distance.upper);
        EXPECT_EQ(one.point_a, many.point_a);
        EXPECT_EQ(one.point_b, many.point_b);
        EXPECT_EQ(one.triangle_a, many.triangle_a);
        EXPECT_EQ(one.triangle_b, many.triangle_b);
        EXPECT_EQ(one.splits, many.splits);
        const MeanDeviation mean_many = mean(threads);
        EXPECT_EQ(mean_one.mean.lower, mean_many.mean.lower);
        EXPECT_EQ(mean_one.mean.upper, mean_many.mean.upper);
        EXPECT_EQ(mean_one.root_mean_square.lower, mean_many.root_mean_square.lower);
        EXPECT_EQ(mean_one.root_mean_square.upper, mean_many.root_mean_square.upper);
        EXPECT_EQ(mean_one.histogram, mean_many.histogram);
        EXPECT_EQ(mean_one.splits, mean_many.splits);
    }
}

TEST(MeshDeviation, IsHonestWhereItEndsEarly)
{
    const TriangleMesh a = sample_mesh("icosphere:2").value();
    const TriangleMesh b = sample_mesh("icosphere:3").value();
    const GreatestDeviation whole = greatest_of(a, b, {.tolerance = 1e-9});
    EXPECT_TRUE(whole.is_complete);
    EXPECT_GT(whole.splits, 1000U);
    const GreatestDeviation part = greatest_of(a, b, {.tolerance = 1e-9, .max_splits = 100});
    EXPECT_FALSE(part.is_complete);
    EXPECT_LT(part.splits, whole.splits);
    EXPECT_LE(part.distance.lower, whole.distance.upper);
    EXPECT_GE(part.distance.upper, whole.distance.lower);
    EXPECT_GT(part.distance.upper - part.distance.lower, 1e-9);
    const MeanDeviation mean = mean_of(a, b, {.tolerance = 1e-7});
    EXPECT_TRUE(mean.is_complete);
    EXPECT_GT(mean.splits, 64U * a.triangle_count());
    const MeanDeviation early = mean_of(a, b, {.tolerance = 1e-7, .max_splits = 1});
    EXPECT_FALSE(early.is_complete);
    EXPECT_LE(early.mean.lower, mean.mean.upper);
    EXPECT_GE(early.mean.upper, mean.mean.lower);
    // A tolerance that doubles cannot reach.
    const GreatestDeviation finest = greatest_of(a, b, {.tolerance = 1e-300});
    EXPECT_FALSE(finest.is_complete);
    EXPECT_LT(finest.distance.upper - finest.distance.lower, 1e-11);
}

TEST(MeshDeviation, ScalesWithMeshesOfAnySize)
{
    const TriangleMesh a = sample_mesh("icosphere:1").value();
    const TriangleMesh b = cube_mesh(Vec3(0.1, 0, 0), 0.75);
    const TriangleMesh centered = cube_mesh(Vec3::Zero(), 0.75); // equally far from many corners
    const GreatestDeviation usual = greatest_of(a, b);
    const auto places_of = [](const TriangleMesh& from, const TriangleMesh& to, int exponent) {
        return greatest_of(from, to,
                           {.tolerance = std::ldexp(0x1p-7, exponent),
                            .max_places = 8,
                            .place_spacing = std::ldexp(0.25, exponent)});
    };
    const auto mean_at = [](const TriangleMesh& from, const TriangleMesh& to, int exponent) {
        return mean_of(from, to,
                       {.tolerance = std::ldexp(1e-3, exponent),
                        .histogram_bins = 8,
                        .histogram_end = std::ldexp(0.5, exponent)});
    };
    const GreatestDeviation usual_places = places_of(a, centered, 0);
    EXPECT_GT(usual_places.places.size(), 1U);
    EXPECT_LT(usual_places.places.size(), 8U);
    const double finest = greatest_of(a, centered).distance.upper;
    EXPECT_NE(usual_places.distance.upper, finest); // by the tolerance
    const MeanDeviation usual_mean = mean_at(a, b, 0);
    for (const int exponent : {-660, -100, 100, 530, 1000}) {
        SCOPED_TRACE(exponent);
        const auto back = [&](const Vec3& p) {
            return Vec3(std::ldexp(p.x(), -exponent), std::ldexp(p.y(), -exponent),
                        std::ldexp(p.z(), -exponent));
        };
        const auto scaled = [&](const TriangleMesh& mesh) {
            return moved(mesh, [&](const Vec3& p) {
                return Vec3(std::ldexp(p.x(), exponent), std::ldexp(p.y(), exponent),
                            std::ldexp(p.z(), exponent));
            });
        };
        const GreatestDeviation other = greatest_of(scaled(a), scaled(b));
        EXPECT_EQ(std::ldexp(other.distance.lower, -exponent), usual.distance.lower);
        EXPECT_EQ(std::ldexp(other.distance.upper, -exponent), usual.distance.upper);
        EXPECT_EQ(back(other.point_a), usual.point_a);
        EXPECT_EQ(back(other.point_b), usual.point_b);
        const GreatestDeviation places = places_of(scaled(a), scaled(centered), exponent);
        EXPECT_EQ(std::ldexp(places.distance.upper, -exponent), usual_places.distance.upper);
        ASSERT_EQ(places.places.size(), usual_places.places.size());
        for (std::size_t i = 0; i < places.places.size(); ++i) {
            const FarPlace& place = places.places[i];
            EXPECT_EQ(std::ldexp(place.distance, -exponent), usual_places.places[i].distance);
            EXPECT_EQ(back(place.point_a), usual_places.places[i].point_a);
            EXPECT_EQ(back(place.point_b), usual_places.places[i].point_b);
        }
        const MeanDeviation mean = mean_at(scaled(a), scaled(b), exponent);
        EXPECT_EQ(mean.histogram, usual_mean.histogram);
        EXPECT_EQ(std::ldexp(mean.mean.lower, -exponent), usual_mean.mean.lower);
        EXPECT_EQ(std::ldexp(mean.mean.upper, -exponent), usual_mean.mean.upper);
        EXPECT_EQ(std::ldexp(mean.root_mean_square.upper, -exponent),
                  usual_mean.root_mean_square.upper);
    }
}

TEST(MeshDeviation, RoundsOutwardWhereDoublesEnd)
{
    // Coordinates that scaling makes 0 are no reason to call triangles the same.
    const auto corner_at = [](double z) {
        return mesh_of({Vec3(0, 0, z), Vec3(1e160, 0, z), Vec3(0, 1e160, z)}, {{0, 1, 2}});
    };
    const DistanceBounds apart = greatest_of(corner_at(0), corner_at(1e-200)).distance;
    EXPECT_LE(apart.lower, 1e-200);
    EXPECT_GE(apart.upper, 1e-200);
    // Less than the smallest double: 1 / sqrt(3) of it.
    const double least = 5e-324;
    const TriangleMesh point = mesh_of({Vec3(0, 0, 0)}, {{0, 0, 0}});
    const TriangleMesh tiny =
        mesh_of({Vec3(least, 0, 0), Vec3(0, least, 0), Vec3(0, 0, least)}, {{0, 1, 2}});
    const DistanceBounds smallest = greatest_of(point, tiny).distance;
    EXPECT_EQ(smallest.lower, 0);
    EXPECT_EQ(smallest.upper, least);
}

TEST(MeshDeviation, NeverCutsMoreThanItMay)
{
    const MeshIndex a = index_of(sample_mesh("icosphere:2").value());
    const MeshIndex b = index_of(sample_mesh("icosphere:3").value());
    const GreatestDeviation whole = greatest_deviation(a, b, {.tolerance = 1e-9}).value();
    for (const std::uint64_t most : {0U, 1U, 2U, 63U, 64U, 65U, 1000U}) {
        SCOPED_TRACE(most);
        const GreatestDeviation part =
            greatest_deviation(a, b, {.tolerance = 1e-9, .max_splits = most}).value();
        EXPECT_LE(part.splits, most);
        EXPECT_LE(part.distance.lower, whole.distance.upper);
        EXPECT_GE(part.distance.upper, whole.distance.lower);
    }
    // Where memory ends the search the bounds hold as well.
    const DistanceBounds small =
        greatest_deviation(a, b, {.tolerance = 1e-9, .execution = {.budget = {.bytes = 400'000}}})
            .value()
            .distance;
    EXPECT_LE(small.lower, whole.distance.upper);
    EXPECT_GE(small.upper, whole.distance.lower);
}

TEST(MeshDeviation, MeansStayWithinTheirBudget)
{
    // One large triangle near many small ones wants most memory: here it has to start parts anew.
    const TriangleMesh one =
        mesh_of({Vec3(-2, -2, 0.9), Vec3(2, -2, 1), Vec3(0, 3, 1.1)}, {{0, 1, 2}});
    const MeshIndex a = index_of(one);
    const MeshIndex b = index_of(sample_mesh("icosphere:4").value());
    const MeanDeviation whole = mean_deviation(a, b, {.tolerance = 1e-4}).value();
    EXPECT_TRUE(whole.is_complete);
    const auto within = [&](std::uint64_t bytes, int threads) {
        return mean_deviation(
            a, b,
            {.tolerance = 1e-4, .execution = {.threads = {threads}, .budget = {.bytes = bytes}}});
    };
    const MeanDeviation small = within(1'100'000, 1).value();
    EXPECT_LE(small.mean.lower, whole.mean.upper);
    EXPECT_GE(small.mean.upper, whole.mean.lower);
    for (const int threads : {2, 5}) {
        const MeanDeviation again = within(1'100'000, threads).value();
        EXPECT_EQ(again.mean.lower, small.mean.lower);
        EXPECT_EQ(again.mean.upper, small.mean.upper);
        EXPECT_EQ(again.splits, small.splits);
    }
    const auto too_small = within(900'000, 1);
    ASSERT_FALSE(too_small);
    EXPECT_EQ(code_of(too_small), ErrorCode::budget_exceeded);
}

TEST(MeshDeviation, CanBeCancelledAndRefusesBadArguments)
{
    const MeshIndex a = index_of(sample_mesh("icosphere:2").value());
    const MeshIndex b = index_of(sample_mesh("icosphere:3").value());
    cancel_at_every_stage(
        [&](Progress& progress) {
            return greatest_deviation(a, b,
                                      {.max_places = 9, .execution = {.progress = &progress}});
        },
        [] { return true; });
    cancel_at_every_stage(
        [&](Progress& progress) {
            return mean_deviation(a, b, {.tolerance = 1e-3, .execution = {.progress = &progress}});
        },
        [] { return true; });
    const auto place_of = [](const auto& result) {
        return result ? std::string("none") : result.error().where;
    };
    EXPECT_EQ(place_of(greatest_deviation(MeshIndex(), b)), "a");
    EXPECT_EQ(place_of(greatest_deviation(a, MeshIndex())), "b");
    EXPECT_EQ(place_of(mean_deviation(MeshIndex(), b)), "a");
    EXPECT_EQ(place_of(greatest_deviation(a, b, {.tolerance = -1})), "tolerance");
    EXPECT_EQ(place_of(greatest_deviation(a, b, {.tolerance = NAN})), "tolerance");
    EXPECT_EQ(place_of(greatest_deviation(a, b, {.max_places = 257})), "max_places");
    EXPECT_EQ(place_of(greatest_deviation(a, b, {.max_places = 1, .place_spacing = -1})),
              "place_spacing");
    EXPECT_EQ(place_of(mean_deviation(a, b, {.tolerance = NAN})), "tolerance");
    EXPECT_EQ(place_of(mean_deviation(a, b, {.histogram_bins = 3})), "histogram_end");
    EXPECT_EQ(place_of(mean_deviation(a, b, {.histogram_bins = 5000, .histogram_end = 1})),
              "histogram_bins");
    const auto small = greatest_deviation(a, b, {.execution = {.budget = {.bytes = 1000}}});
    ASSERT_FALSE(small);
    EXPECT_EQ(code_of(small), ErrorCode::budget_exceeded);
    const auto no_area =
        mean_deviation(index_of(mesh_of({Vec3(0, 0, 0), Vec3(1, 1, 1)}, {{0, 1, 1}})), b);
    ASSERT_FALSE(no_area);
    EXPECT_EQ(code_of(no_area), ErrorCode::invalid_mesh);
    EXPECT_NE(no_area.error().message.find("has no area"), std::string::npos);
    // An area that is there, but lost beside the other mesh.
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 1);
    const auto lost = mean_deviation(
        index_of(cube), index_of(moved(cube, [](const Vec3& p) { return Vec3(1e100 * p); })));
    ASSERT_FALSE(lost);
    EXPECT_EQ(code_of(lost), ErrorCode::invalid_mesh);
    EXPECT_NE(lost.error().message.find("too small"), std::string::npos) << lost.error().message;
}

} // namespace
} // namespace proxima::mesh_deviation_test
