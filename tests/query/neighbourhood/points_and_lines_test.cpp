// Point clouds and polylines as meshes of triangles without area: every query against a loop over all
// points or segments.
#include "geometry/closest_point.h"
#include "index/test_meshes.h"
#include "proxima/cast_ray.h"
#include "proxima/closest_feature.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "proxima/neighbourhood.h"
#include "proxima/signed_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <set>

namespace proxima::points_and_lines_test {
namespace {

using namespace testing;

using Segments = std::vector<std::array<std::uint32_t, 2>>;

std::vector<Vec3> random_points(std::mt19937& random, std::size_t count)
{
    std::uniform_real_distribution<double> coordinate(-1, 1);
    std::vector<Vec3> points(count);
    for (Vec3& point : points)
        point = Vec3(coordinate(random), coordinate(random), coordinate(random));
    return points;
}

/// Points of a grid: duplicates, many at one distance, on lines and planes.
std::vector<Vec3> grid_points(std::mt19937& random, std::size_t count)
{
    std::vector<Vec3> points(count);
    for (Vec3& point : points)
        for (double& coordinate : point) coordinate = static_cast<double>(random() % 4);
    return points;
}

/// A walk through the points, with steps of no length.
Segments random_segments(std::mt19937& random, std::size_t points)
{
    Segments segments;
    for (std::uint32_t i = 0; i + 1 < points; ++i) segments.push_back({i, i + 1});
    for (int i = 0; i < 5; ++i) {
        const auto vertex = static_cast<std::uint32_t>(random() % points);
        segments.push_back({vertex, vertex});
    }
    return segments;
}

class PointClouds : public ::testing::TestWithParam<int> {
protected:
    PointClouds() : random(static_cast<std::uint32_t>(GetParam()))
    {
        const std::size_t count = 1 + random() % 300;
        positions = GetParam() % 2 == 0 ? random_points(random, count) : grid_points(random, count);
    }

    /// A position of the cloud, or near it.
    Vec3 query()
    {
        const Vec3& position = positions[random() % positions.size()];
        return random() % 3 == 0 ? position : Vec3(position + random_points(random, 1)[0]);
    }

    std::mt19937 random;
    std::vector<Vec3> positions;
};

TEST_P(PointClouds, ClosestPointsAreThoseOfALoop)
{
    const MeshIndex plain = build_mesh_index(mesh_of_points(positions).value()).value();
    const MeshIndex listed = with_lists(plain).value();
    for (int i = 0; i < 200; ++i) {
        const Vec3 p = query();
        std::uint32_t nearest = 0;
        for (std::uint32_t k = 1; k < positions.size(); ++k) {
            if ((positions[k] - p).squaredNorm() < (positions[nearest] - p).squaredNorm())
                nearest = k;
        }
        const auto closest = closest_feature(plain, p);
        ASSERT_TRUE(closest);
        EXPECT_EQ(closest->feature, (Feature{FeatureKind::vertex, nearest}));
        EXPECT_EQ(closest->triangle, TriangleId{nearest});
        EXPECT_EQ(closest->point, positions[nearest]);
        const auto by_lists = closest_feature(listed, p);
        ASSERT_TRUE(by_lists);
        EXPECT_EQ(by_lists->feature, closest->feature);
        EXPECT_EQ(by_lists->squared_distance, closest->squared_distance);

        std::vector<NearTriangle> all;
        for (std::uint32_t k = 0; k < positions.size(); ++k)
            all.push_back({(positions[k] - p).squaredNorm(), TriangleId{k}});
        std::ranges::sort(all, std::less<>());
        std::vector<NearTriangle> near(std::min<std::size_t>(7, all.size()));
        EXPECT_EQ(collect_nearest(plain, p, near).written, near.size());
        for (std::size_t k = 0; k < near.size(); ++k) EXPECT_EQ(near[k].triangle, all[k].triangle);

        const Box box{p - Vec3(0.5, 1, 0.25), p + Vec3(0.5, 1, 0.25)};
        std::set<std::uint32_t> inside;
        std::set<std::uint32_t> found;
        for (std::uint32_t k = 0; k < positions.size(); ++k)
            if (box.contains(positions[k])) inside.insert(k);
        std::vector<TriangleId> ids(positions.size());
        const Neighbourhood written = collect_triangles(plain, box, ids);
        for (std::size_t k = 0; k < written.written; ++k) found.insert(to_index(ids[k]));
        EXPECT_EQ(found, inside);
    }
}

TEST_P(PointClouds, DistancesAndContactsOfCloudsAreThoseOfALoop)
{
    const std::vector<Vec3> others =
        GetParam() % 2 == 0 ? random_points(random, 50) : grid_points(random, 20);
    const MeshIndex a = build_mesh_index(mesh_of_points(positions).value()).value();
    const MeshIndex b =
        with_slabs(build_mesh_index(mesh_of_points(others).value()).value()).value();
    double least = std::numeric_limits<double>::infinity();
    std::size_t pairs = 0;
    for (const Vec3& p : positions) {
        for (const Vec3& q : others) {
            least = std::min(least, (p - q).norm());
            pairs += p == q ? 1 : 0;
        }
    }
    const auto distance = mesh_distance(a, b);
    ASSERT_TRUE(distance);
    EXPECT_DOUBLE_EQ(distance->distance, least);
    EXPECT_EQ(intersecting_pairs(a, b, RigidTransform{}).size(), pairs);
    EXPECT_EQ(meshes_intersect(a, b), pairs > 0);
}

TEST_P(PointClouds, RaysHitWhatTheyMeetExactly)
{
    const MeshIndex index = build_mesh_index(mesh_of_points(positions).value()).value();
    int hits = 0;
    for (int i = 0; i < 100; ++i) {
        const Vec3& target = positions[random() % positions.size()];
        Ray ray{target, Vec3::Zero()};
        ray.direction[static_cast<int>(random() % 3)] = 1;
        ray.origin -= 2.0 * ray.direction; // exact on the grid, rounded elsewhere
        std::size_t on_ray = 0;
        for (const Vec3& p : positions) {
            const Vec3 along = p - ray.origin;
            const Vec3 aside = along - along.dot(ray.direction) * ray.direction;
            on_ray += aside == Vec3::Zero() && along.dot(ray.direction) >= 0 ? 1 : 0;
        }
        EXPECT_EQ(all_hits(index, ray).size(), on_ray);
        hits += static_cast<int>(on_ray);
        ray.origin += Vec3(0.125, 0.125, 0.125);
        if (GetParam() % 2 != 0) {
            EXPECT_FALSE(any_hit(index, ray));
        }
    }
    EXPECT_GE(hits, 100);
}

TEST_P(PointClouds, SegmentsAreThoseOfALoop)
{
    const Segments segments = random_segments(random, positions.size());
    const TriangleMesh mesh = mesh_of_segments(positions, segments).value();
    const MeshIndex index = with_lists(build_mesh_index(mesh).value()).value();
    for (int i = 0; i < 200; ++i) {
        const Vec3 p = query();
        double least = std::numeric_limits<double>::infinity();
        for (const auto& [v, w] : segments) {
            const SegmentPoint nearest = closest_point(Segment{positions[v], positions[w]}, p);
            least = std::min(least, (p - nearest.point).norm());
        }
        const auto closest = closest_feature(index, p);
        ASSERT_TRUE(closest);
        // Both round a point of the segment to doubles.
        EXPECT_NEAR(std::sqrt(closest->squared_distance), least, 1e-15 * 8);
        EXPECT_NE(closest->feature.kind, FeatureKind::face);
    }
}

TEST_P(PointClouds, HaveNoInside)
{
    const MeshIndex index =
        with_signs(build_mesh_index(mesh_of_points(positions).value()).value()).value();
    for (int i = 0; i < 50; ++i) {
        const Vec3 p = query();
        const auto distance = signed_distance(index, p);
        ASSERT_TRUE(distance);
        EXPECT_GE(distance->distance, 0);
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, PointClouds, ::testing::Range(0, 20));

} // namespace
} // namespace proxima::points_and_lines_test
