// Point proxies at corners that have ridges and valleys: none rests where a point could go on.
#include "haptics/proxy/corner_ways.h"

#include "geometry/triangle_contact.h"
#include "haptics/proxy/proxy.h"
#include "haptics/proxy/slide_sphere.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <vector>

namespace proxima::corner_ways_test {
namespace {

using testing::mesh_of;

/// Triangles round a corner at the origin.
struct Corner {
    TriangleMesh mesh;
    Vec3 towards; ///< where a hand pushes
};

/// Corners of a scan at which three faces held a proxy, though slopes of two to fourteen degrees lead
/// on.
std::vector<Corner> corners_of_a_scan()
{
    return {{mesh_of({Vec3(0.690, -2.419, 0.134), Vec3(0.195, -1.660, 1.706),
                      Vec3(0.781, -1.902, -0.728), Vec3(0.131, -0.063, -1.777),
                      Vec3(-0.196, 0.168, 1.995), Vec3(0, 0, 0), Vec3(-0.990, 1.933, 0.940),
                      Vec3(-1.938, 1.924, -0.003)},
                     {{1, 4, 5}, {3, 2, 5}, {0, 5, 2}, {5, 4, 6}, {0, 1, 5}, {5, 6, 7}, {3, 5, 7}}),
             Vec3(0.925674, 0.296913, 0.234459)},
            {mesh_of({Vec3(0, 0, 0), Vec3(0.821, -1.805, 0.051), Vec3(1.225, 0.048, 1.464),
                      Vec3(-1.342, 1.913, 1.162), Vec3(-0.027, 2.028, 2.094),
                      Vec3(-1.245, -0.161, -1.701), Vec3(0.208, -1.899, -1.165)},
                     {{0, 1, 2}, {3, 0, 4}, {0, 2, 4}, {5, 0, 3}, {0, 5, 6}, {0, 6, 1}}),
             Vec3(0.519751, 0.571593, -0.634933)},
            {mesh_of({Vec3(0.014, -1.997, 2.286), Vec3(-1.278, -0.091, 1.141),
                      Vec3(-1.295, 1.869, -0.658), Vec3(0, 0, 0), Vec3(-0.012, 1.914, -1.150),
                      Vec3(1.281, -2.295, -0.244), Vec3(0.593, -0.510, -1.756)},
                     {{1, 2, 3}, {1, 3, 0}, {0, 3, 5}, {5, 3, 6}, {4, 6, 3}, {2, 4, 3}}),
             Vec3(0.716428, 0.544196, 0.436557)}};
}

/// A star whose spokes go up and down at random, round a top or in a hollow.
Corner random_corner(std::mt19937_64& random)
{
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto spokes = static_cast<std::uint32_t>(4 + random() % 6U);
    const double rise = 0.4 * unit(random);
    std::vector<Vec3> positions = {Vec3::Zero()};
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < spokes; ++i) {
        const double angle = 2 * std::numbers::pi * i / spokes;
        positions.emplace_back(std::cos(angle), std::sin(angle), rise + 0.4 * unit(random));
        triangles.push_back({0, i + 1, (i + 1) % spokes + 1});
    }
    const double x = 0.3 * unit(random);
    const double y = 0.3 * unit(random);
    return {mesh_of(std::move(positions), std::move(triangles)), Vec3(x, y, -1).normalized()};
}

/// Where a point ends that comes down on the corner.
Vec3 end_of_slide(const Corner& corner, const Vec3& goal)
{
    const MeshContactSurface surface(corner.mesh);
    Proxy proxy(surface, {});
    proxy.place(-0.1 * corner.towards);
    for (int tick = 0; tick < 50; ++tick) proxy.follow(goal);
    EXPECT_EQ(proxy.last().slide.end, SlideEnd::settled);
    return proxy.last().proxy;
}

bool passes(const TriangleMesh& mesh, const Vec3& from, const Vec3& to)
{
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        if (segment_meets_triangle(from, to, mesh.triangle(TriangleId{id}))) return true;
    }
    return false;
}

/// Whether some of many short straight ways leads nearer to the goal by more than a slope of two
/// degrees and passes no triangle.
bool can_come_nearer(const Corner& corner, const Vec3& p, const Vec3& goal, std::mt19937_64& random)
{
    std::normal_distribution<double> normal;
    const Vec3 towards = (goal - p).normalized();
    for (int i = 0; i < 3000; ++i) {
        const Vec3 any = Vec3{normal(random), normal(random), normal(random)};
        const Vec3 way = (i % 2 == 0 ? any : Vec3(any - any.dot(towards) * towards + 0.1 * towards))
                             .normalized();
        if (way.dot(towards) > 0.035 && !passes(corner.mesh, p, p + 1e-4 * way)) return true;
    }
    return false;
}

TEST(CornerWays, LetAPointGoOnWhereOnlyItsGapIsHeld)
{
    std::mt19937_64 random(1);
    for (const Corner& corner : corners_of_a_scan()) {
        const Vec3 goal = 0.3 * corner.towards;
        const Vec3 end = end_of_slide(corner, goal);
        EXPECT_GT(end.norm(), 1e-3) << "held at the corner";
        EXPECT_FALSE(can_come_nearer(corner, end, goal, random)) << end.transpose();
    }
}

TEST(CornerWays, EndWhereNothingIsNearer)
{
    const std::uint64_t seed = 20261127;
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    int at_corners = 0;
    for (int i = 0; i < 300; ++i) {
        const Corner corner = random_corner(random);
        const Vec3 goal = 0.2 * corner.towards;
        const Vec3 end = end_of_slide(corner, goal);
        EXPECT_FALSE(can_come_nearer(corner, end, goal, random)) << i << ": " << end.transpose();
        at_corners += end.norm() < 1e-6 ? 1 : 0;
    }
    EXPECT_GT(at_corners, 10) << "some corners hold a point";
}

std::vector<ContactTriangle> all_of(const TriangleMesh& mesh)
{
    std::vector<ContactTriangle> all;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id)
        all.push_back({mesh.triangle(TriangleId{id}), TriangleId{id}});
    return all;
}

TEST(CornerWays, LeadOutOfNoRoomsCorner)
{
    // Walls that meet at right angles, seen from inside, one of them in two parts that hardly lean.
    const std::vector<Vec3> positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1),
                                         Vec3(-1e-3, 1, 1)};
    const TriangleMesh three = mesh_of(positions, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}});
    const TriangleMesh four = mesh_of(positions, {{0, 1, 2}, {0, 2, 4}, {0, 4, 3}, {0, 3, 1}});
    const double gap = 1e-9;
    for (const TriangleMesh& walls : {three, four}) {
        EXPECT_FALSE(way_from_corner(all_of(walls), Vec3::Constant(gap), -Vec3::Ones().normalized(),
                                     0.01, gap));
    }
    // Three faces leave the line where two of them meet: a slide finds that by itself.
    EXPECT_FALSE(way_from_corner(all_of(three), Vec3::Constant(1.5 * gap),
                                 Vec3(-1, -1, 0.5).normalized(), 0.01, gap));
}

// The corner is not at the origin here, so that a face's side is a matter of where the face lies.
TEST(CornerWays, AreTheSameAnywhere)
{
    const double gap = 0x1p-20;
    const Vec3 offset(3, -2, 5);
    for (const Corner& corner : corners_of_a_scan()) {
        std::vector<ContactTriangle> moved = all_of(corner.mesh);
        for (ContactTriangle& one : moved)
            for (Vec3& position : one.corners.vertices) position += offset;
        const Vec3 p = -1.5 * gap * corner.towards;
        const auto way = way_from_corner(all_of(corner.mesh), p, corner.towards, 0.01, gap);
        const auto moved_way = way_from_corner(moved, p + offset, corner.towards, 0.01, gap);
        ASSERT_TRUE(way && moved_way);
        EXPECT_LT((*way - *moved_way).norm(), 1e-6 * way->norm());
    }
}

// On a pyramid's top four ways are as steep as each other.
TEST(CornerWays, DoNotDependOnTheOrderOfTriangles)
{
    const double gap = 0x1p-20;
    const TriangleMesh pyramid =
        mesh_of({Vec3(0, 0, 0), Vec3(1, 1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, -1), Vec3(1, -1, -1)},
                {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}});
    std::vector<ContactTriangle> near = all_of(pyramid);
    const Vec3 p = 1.5 * gap * Vec3::UnitZ();
    const auto way = way_from_corner(near, p, -Vec3::UnitZ(), 0.01, gap);
    ASSERT_TRUE(way);
    std::mt19937_64 random(1);
    for (int i = 0; i < 20; ++i) {
        std::ranges::shuffle(near, random);
        EXPECT_EQ(way_from_corner(near, p, -Vec3::UnitZ(), 0.01, gap), way);
    }
}

/// A ramp that falls towards +x, by one in ten, and three walls beside and behind the origin that lean and cross its slope.
std::vector<ContactTriangle> ramp_with_walls(double gap)
{
    const double near = 6 * gap;
    const auto wall = [&](const Vec3& at, const Vec3& along, const Vec3& up) {
        return Triangle{at - along, at + along, at + up};
    };
    return {{Triangle{Vec3(-1e4 * gap, -2e4 * gap, 1e3 * gap), Vec3(2e4 * gap, 0, -2e3 * gap),
                      Vec3(-1e4 * gap, 2e4 * gap, 1e3 * gap)},
             TriangleId{0}},
            {wall({-near, near, 0}, gap * Vec3(2, 3, 0), gap * Vec3(-3, 2, 4)), TriangleId{1}},
            {wall({-near, -near, 0}, gap * Vec3(2, -3, 0), gap * Vec3(-3, -2, 4)), TriangleId{2}},
            {wall({-1.5 * near, 0, 0}, gap * Vec3(1, 4, 0), gap * Vec3(-3, 0, 4)), TriangleId{3}}};
}

TEST(CornerWays, MayLeadDownAFace)
{
    const double gap = 1e-6;
    const Vec3 normal = Vec3(0.1, 0, 1).normalized();
    const Vec3 p = 1.5 * gap * normal;
    const auto way = way_from_corner(ramp_with_walls(gap), p, -Vec3::UnitZ(), 0.01, gap);
    ASSERT_TRUE(way);
    EXPECT_GT(way->normalized().dot(Vec3(1, 0, -0.1).normalized()), 0.999) << way->transpose();
    // However many triangles the ramp has.
    std::vector<ContactTriangle> divided = ramp_with_walls(gap);
    for (std::uint32_t i = 0; i < 20; ++i)
        divided.push_back({divided.front().corners, TriangleId{4 + i}});
    EXPECT_EQ(way_from_corner(divided, p, -Vec3::UnitZ(), 0.01, gap), way);
}

TEST(CornerWays, EndMoreThanAGapFromAll)
{
    const double gap = 1e-6;
    const Vec3 p = 1.5 * gap * Vec3(0.1, 0, 1).normalized();
    std::vector<ContactTriangle> scene = ramp_with_walls(gap);
    const auto way = way_from_corner(scene, p, -Vec3::UnitZ(), 0.01, gap);
    ASSERT_TRUE(way);
    const auto beside_its_end = [&](double gaps) {
        const Vec3 at = p + *way + Vec3(0, gaps * gap, 0);
        return ContactTriangle{{at, at + Vec3(0, gap, 0), at + Vec3(0, gap, gap)}, TriangleId{4}};
    };
    scene.push_back(beside_its_end(1.5));
    EXPECT_EQ(way_from_corner(scene, p, -Vec3::UnitZ(), 0.01, gap), way);
    scene.back() = beside_its_end(0.5);
    EXPECT_NE(way_from_corner(scene, p, -Vec3::UnitZ(), 0.01, gap), way);
}

TEST(CornerWays, AreSteeperThanAsked)
{
    const double gap = 1e-9;
    for (const Corner& corner : corners_of_a_scan()) {
        const Vec3 p = -1.5 * gap * corner.towards;
        const auto way = way_from_corner(all_of(corner.mesh), p, corner.towards, 0.05, gap);
        ASSERT_TRUE(way);
        EXPECT_NEAR(way->norm(), corner_way * gap, 1e-12 * corner_way * gap);
        EXPECT_FALSE(passes(corner.mesh, p, p + *way));
        const double cosine = way->dot(corner.towards) / way->norm();
        EXPECT_GT(cosine, 0.05);
        EXPECT_TRUE(way_from_corner(all_of(corner.mesh), p, corner.towards, 0.99 * cosine, gap));
        EXPECT_FALSE(way_from_corner(all_of(corner.mesh), p, corner.towards, cosine, gap));
    }
}

} // namespace
} // namespace proxima::corner_ways_test
