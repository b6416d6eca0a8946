#include "haptics/proxy/slide_sphere.h"

#include "counted_allocations.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scenes_to_touch.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "index/listed_index.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <memory>

namespace proxima::slide_sphere_test {
namespace {

using testing::HandPath;
using testing::passes;
using testing::TouchMesh;

double distance_of(const TriangleMesh& mesh, const Vec3& p)
{
    double least = INFINITY;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id)
        least = std::min(least, (closest_point(mesh.triangle(TriangleId{id}), p).point - p).norm());
    return least;
}

/// A plane large enough, in four triangles of which none is parallel to an axis' diagonal.
TriangleMesh plane_mesh()
{
    return testing::mesh_of(
        {Vec3(-3, -2, 0), Vec3(2, -3, 0), Vec3(3, 2, 0), Vec3(-2, 3, 0), Vec3(0.1, 0.2, 0)},
        {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
}

TEST(SlideSphere, IsExactOnAPlaneToABillionthOfTheDepth)
{
    const TriangleMesh mesh = plane_mesh();
    const MeshContactSurface surface(mesh);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-1, 1);
    for (const double radius : {0.0, 0.3}) {
        Proxy proxy(surface, {.radius = radius});
        proxy.place(Vec3(0, 0, 1));
        double squares = 0;
        double depths = 0;
        for (int tick = 0; tick < 3000; ++tick) {
            const Vec3 device(place(random), place(random), -0.05 * (1.1 + place(random)));
            const ProxyTick& result = proxy.follow(device);
            EXPECT_EQ(result.slide.end, SlideEnd::settled);
            const Vec3 expected(device.x(), device.y(), radius);
            squares += (result.anchor - expected).squaredNorm();
            depths += (expected - device).squaredNorm();
        }
        EXPECT_LT(std::sqrt(squares / depths), 1e-9) << radius;
    }
}

TEST(SlideSphere, IsExactOnACubeToABillionthOfTheDepth)
{
    const TriangleMesh mesh = *sample_mesh("cube");
    const MeshContactSurface surface(mesh);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> place(-1, 1);
    for (const double radius : {0.0, 0.25}) {
        for (int tick = 0; tick < 3000; ++tick) {
            // From above a face to a place under it, nearer to it than to any other.
            const int axis = tick % 3;
            const double side = tick % 2 == 0 ? 1 : -1;
            Vec3 above(0.85 * place(random), 0.85 * place(random), 0.85 * place(random));
            above[axis] = side * 1.5;
            Vec3 device(0.85 * place(random), 0.85 * place(random), 0.85 * place(random));
            device[axis] = side * (1 - 0.12 * std::abs(place(random)));
            Proxy proxy(surface, {.radius = radius});
            proxy.place(above);
            const ProxyTick& result = proxy.follow(device);
            Vec3 expected = device;
            expected[axis] = side * (1 + radius);
            const double depth = (expected - device).norm();
            EXPECT_LT((result.anchor - expected).norm(), 1e-9 * depth + 1e-15) << tick;
        }
    }
}

// A sphere of radius r against one corner is a point against a sphere of radius r.
TEST(SlideSphere, IsExactOnASphereToABillionthOfTheDepth)
{
    const TriangleMesh mesh =
        testing::mesh_of({Vec3(0, 0, 0), Vec3(-0.01, 0, -10), Vec3(0.01, 0.01, -10)}, {{0, 1, 2}});
    const MeshContactSurface surface(mesh);
    const double radius = 0.5;
    Proxy proxy(surface, {.radius = radius});
    proxy.place(Vec3(0, 0, 1));
    double squares = 0;
    double depths = 0;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-1, 1);
    for (int tick = 0; tick < 3000; ++tick) {
        const Vec3 direction = Vec3{place(random), place(random), 1}.normalized();
        const Vec3 device = (0.1 + 0.39 * std::abs(place(random))) * direction;
        proxy.follow(device);
        const ProxyTick& result = proxy.follow(device);
        const Vec3 expected = radius * direction;
        squares += (result.anchor - expected).squaredNorm();
        depths += (expected - device).squaredNorm();
    }
    EXPECT_LT(std::sqrt(squares / depths), 1e-9);
}

TEST(SlideSphere, ReachesACornerOfThreePlanesInOneTick)
{
    for (const double slant : {0.0, -0.5, 0.3}) {
        const TriangleMesh mesh = testing::inner_corner(slant);
        const MeshContactSurface surface(mesh);
        for (const double radius : {0.0, 0.1}) {
            Proxy proxy(surface, {.radius = radius});
            proxy.place(Vec3(1.0, 0.8, 0.9));
            const ProxyTick& result = proxy.follow(Vec3(-0.3, -0.35, -0.25));
            EXPECT_EQ(result.slide.end, SlideEnd::settled);
            EXPECT_EQ(result.slide.contact_count, 3U);
            for (std::uint32_t id = 0; id < 3; ++id) {
                const Triangle face = mesh.triangle(TriangleId{id});
                const Vec3 normal = scaled_normal(face).normalized();
                EXPECT_NEAR(std::abs(normal.dot(result.anchor - face[0])), radius, 1e-10);
            }
        }
    }
}

struct Walk {
    const TouchMesh& named;
    double radius;
    double friction;
};

/// Walks along a path: nothing is passed, nothing is too near, the index and all triangles give
/// the same bits, and no place nearby that can be reached is nearer to the device. Adds the ticks
/// that touch.
void check_walk(const Walk& walk, std::uint32_t seed, int ticks, int& touching)
{
    const TriangleMesh& mesh = walk.named.mesh;
    const auto listed = testing::listed_index(mesh);
    ASSERT_TRUE(listed);
    const IndexContactSurface near(*listed);
    const MeshContactSurface all(mesh);
    EXPECT_EQ(near.scale().mean_edge, all.scale().mean_edge);
    const double size = all.scale().extent;
    const double skin = 0x1p-42 * all.scale().reach;
    const ProxyOptions options = {.radius = walk.radius * size,
                                  .static_friction = walk.friction,
                                  .dynamic_friction = 0.75 * walk.friction};
    Proxy proxy(near, options);
    Proxy slow(all, options);
    HandPath path(mesh, seed);
    const Vec3 begin = path.next() + Vec3(0, 0, 2.5 * size);
    proxy.place(begin);
    slow.place(begin);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    int limited = 0;
    for (int tick = 0; tick < ticks; ++tick) {
        const std::string where = walk.named.name + ", radius " + std::to_string(walk.radius) +
                                  ", seed " + std::to_string(seed) + ", tick " +
                                  std::to_string(tick);
        const Vec3 device = path.next();
        const ProxyTick& result = proxy.follow(device);
        const ProxyTick& expected = slow.follow(device);
        ASSERT_EQ(result.proxy, expected.proxy) << where;
        ASSERT_EQ(result.anchor, expected.anchor) << where;
        ASSERT_EQ(result.hold, expected.hold) << where;
        ASSERT_TRUE(result.anchor.allFinite()) << where;
        ASSERT_NE(result.slide.end, SlideEnd::overloaded) << where;
        for (std::size_t i = 1; i < proxy.path().size(); ++i)
            ASSERT_FALSE(passes(mesh, proxy.path()[i - 1], proxy.path()[i])) << where;
        ASSERT_EQ(proxy.path().back(), result.proxy) << where;
        ASSERT_GE(distance_of(mesh, result.proxy), proxy.radius() - 4 * skin) << where;
        limited += result.slide.end == SlideEnd::limited ? 1 : 0;
        if (result.hold == Hold::free) continue;
        ++touching;
        if (walk.friction > 0 || result.slide.end != SlideEnd::settled) continue;
        // No way down: a short free step never comes nearer to the device.
        const double way = (result.proxy - device).norm();
        if (tick % 7 != 0 || !(way > 1e-3 * size)) continue;
        for (int i = 0; i < 40; ++i) {
            const double length = 1e-6 * size;
            const Vec3 step =
                length * Vec3{normal(random), normal(random), normal(random)}.normalized();
            if (way - (result.proxy + step - device).norm() < 0.02 * length) continue;
            EXPECT_TRUE(distance_of(mesh, result.proxy + step) < proxy.radius() ||
                        passes(mesh, result.proxy, result.proxy + step))
                << where;
        }
    }
    EXPECT_LT(limited, ticks / 20 + 1) << walk.named.name << " radius " << walk.radius;
}

TEST(SlideSphere, PassesThroughNoMesh)
{
    std::uint32_t seed = 100;
    for (const TouchMesh& named : testing::touch_meshes()) {
        const int ticks = named.mesh.triangle_count() > 1000 ? 100 : 300;
        int touching = 0;
        for (const double radius : {0.0, 0.02}) {
            for (const double friction : {0.0, 0.4})
                check_walk({named, radius, friction}, ++seed, ticks, touching);
        }
        EXPECT_GT(touching, 4 * ticks / 20) << named.name << ", seeds to " << seed;
    }
}

TEST(SlideSphere, StaysFiniteWhereTheDeviceIsAllButOnASidesAxis)
{
    const TriangleMesh rod =
        make_triangle_mesh({Vec3(0, 0, 0), Vec3(0, 0, 1)}, {TriangleCorners{0, 1, 1}}).value();
    const MeshContactSurface surface(rod);
    for (const double off : {0x1p-1074, 0x1p-1000, 0x1p-60, 0x1p-20}) {
        Proxy proxy(surface, {.radius = 0.25});
        proxy.place(Vec3(0.5, 0, 0.5));
        for (int tick = 0; tick < 20; ++tick) {
            const Vec3& center = proxy.follow(Vec3(off, 0, 0.6)).proxy;
            ASSERT_TRUE(center.allFinite()) << off;
            EXPECT_GE(std::hypot(center.x(), center.y()), 0.25 - 1e-12) << off;
        }
        const Vec3& center = proxy.last().proxy;
        EXPECT_NEAR(std::hypot(center.x(), center.y()), 0.25, 1e-9) << off;
        EXPECT_NEAR(center.z(), 0.6, 1e-9) << off;
    }
}

TEST(SlideSphere, DoesNotPassAThinWallInAFastPoke)
{
    const TriangleMesh mesh = testing::thin_plate();
    const auto listed = testing::listed_index(mesh);
    const IndexContactSurface surface(*listed);
    Proxy proxy(surface, {});
    for (int tick = 0; tick < 1000; ++tick) {
        proxy.place(Vec3(0.3, 0.2, 0.7));
        const ProxyTick& result = proxy.follow(Vec3(0.3 + 1e-4 * tick, 0.2, -0.001 * tick - 0.01));
        EXPECT_NEAR(result.anchor.z(), 0.0005, 1e-12);
    }
}

// Found on a ship of 33,000 triangles: from above the edge of two faces that are all but flat,
// along one of them and into the other.
TEST(SlideSphere, DoesNotPassNearlyFlatValleys)
{
    std::mt19937 random(12);
    std::uniform_real_distribution<double> number(-1, 1);
    int failures = 0;
    for (int trial = 0; trial < 3000; ++trial) {
        const double rise = std::pow(10.0, -5.5 + 0.8 * number(random));
        const Vec3 axis = Vec3{number(random), number(random), number(random)}.normalized();
        const Mat3 turn = Eigen::AngleAxisd(3 * number(random), axis).toRotationMatrix();
        const auto at = [&](double x, double y, double z) { return Vec3(turn * Vec3(x, y, z)); };
        // Along y; it rises to both sides by half of the angle.
        const TriangleMesh mesh = testing::mesh_of(
            {at(0, -1, 0), at(0, 1, 0), at(1, 0.1, rise / 2), at(-1, -0.1, rise / 2)},
            {{0, 2, 1}, {1, 3, 0}});
        const MeshContactSurface surface(mesh);
        Proxy proxy(surface, {});
        proxy.place(at(0, 0, 0.01));
        const double y = 0.3 * number(random);
        proxy.follow(at(1e-13 * number(random), y, -0.01));
        const Vec3 from = proxy.last().proxy;
        const ProxyTick& result = proxy.follow(at(trial % 2 == 0 ? 0.3 : -0.3, y, -0.01));
        Vec3 last = from;
        for (const Vec3& place : proxy.path()) {
            failures += passes(mesh, last, place) ? 1 : 0;
            last = place;
        }
        EXPECT_NEAR((turn.transpose() * result.anchor).z(), 0.15 * rise, 1e-8) << trial;
    }
    EXPECT_EQ(failures, 0);
}

// As coordinates of six digits give flat faces: strokes along one face into the next, which rises by
// so little that rounding tells the place where its plane is met only to many times the gap.
TEST(SlideSphere, DoesNotPassSeamsThatRoundingBends)
{
    constexpr unsigned seed = 13;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    int failures = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        const double rise = std::pow(10.0, -6.5 + 2 * number(random));
        const Vec3 axis = Vec3{number(random), number(random), number(random)}.normalized();
        const Mat3 turn = Eigen::AngleAxisd(3 * number(random), axis).toRotationMatrix();
        const auto at = [&](double x, double y, double z) { return Vec3(turn * Vec3(x, y, z)); };
        const TriangleMesh mesh =
            testing::mesh_of({at(0, -1, 0), at(0, 1, 0), at(1, 0.3 * number(random), rise),
                              at(-1, 0.3 * number(random), 0)},
                             {{0, 2, 1}, {1, 3, 0}});
        const MeshContactSurface surface(mesh);
        Proxy proxy(surface, {});
        const double y = 0.2 * number(random);
        const double from = -0.16 + 0.15 * number(random);
        const double to = 0.16 + 0.15 * number(random);
        proxy.place(at(from, y, 0.05));
        Vec3 last = at(from, y, 0.05);
        const int ticks = 2 + trial % 4;
        for (int tick = 0; tick < ticks; ++tick) {
            const double part = tick / (ticks - 1.0);
            proxy.follow(at(from + part * (to - from), y + 0.2 * part * number(random), -0.05));
            for (const Vec3& place : proxy.path()) {
                failures += passes(mesh, last, place) ? 1 : 0;
                last = place;
            }
        }
        EXPECT_GT((turn.transpose() * last).z(), 0) << "seed " << seed << ", trial " << trial;
    }
    EXPECT_EQ(failures, 0) << "seed " << seed;
}

TEST(SlideSphere, DoesNotAllocate)
{
    const TriangleMesh mesh = *sample_mesh("torus:24x12");
    const auto listed = testing::listed_index(mesh);
    const IndexContactSurface surface(*listed);
    Proxy proxy(surface, {.radius = 0.02, .static_friction = 0.4, .dynamic_friction = 0.3});
    HandPath path(mesh, 5);
    std::vector<Vec3> devices;
    for (int tick = 0; tick < 500; ++tick) devices.push_back(path.next());
    const std::size_t before = testing::allocation_count();
    proxy.place(devices.front());
    for (const Vec3& device : devices) proxy.follow(device);
    EXPECT_EQ(testing::allocation_count(), before);
}

TEST(SlideSphere, StartsFreeWhereverItIsPut)
{
    for (const TouchMesh& named : testing::touch_meshes()) {
        const MeshContactSurface surface(named.mesh);
        const double size = surface.scale().extent;
        const double skin = 0x1p-42 * surface.scale().reach;
        for (const double radius : {0.0, 0.01}) {
            Proxy proxy(surface, {.radius = radius * size});
            if (named.name == "plate" || named.name == "soup" || named.name == "spaceship")
                continue;
            for (std::uint32_t v = 0; v < named.mesh.vertex_count(); v += 7) {
                proxy.place(named.mesh.positions()[v]);
                EXPECT_GE(distance_of(named.mesh, proxy.last().proxy), proxy.radius() - 4 * skin)
                    << named.name << ' ' << v;
            }
        }
    }
}

} // namespace
} // namespace proxima::slide_sphere_test
