#include "haptics/proxy/free_position.h"

#include "haptics/force/surface_renderer.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scenes_to_touch.h"
#include "haptics/surface/contact_surface.h"
#include "index/listed_index.h"
#include "lab/hand_script.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace proxima::free_position_test {
namespace {

using namespace testing;

double distance_to(const TriangleMesh& mesh, const Vec3& p)
{
    double least = INFINITY;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id)
        least = std::min(least, (closest_point(mesh.triangle(TriangleId{id}), p).point - p).norm());
    return least;
}

TEST(FreePosition, IsFreeWhereverOneIsFound)
{
    SlideScratch scratch;
    for (const TouchMesh& named : touch_meshes()) {
        const auto listed = *testing::listed_index(named.mesh);
        const IndexContactSurface surface(listed);
        const double size = surface.scale().extent;
        const double skin = 0x1p-40 * surface.scale().reach;
        int found = 0;
        int asked = 0;
        for (const double radius : {1e-6, 0.02}) {
            for (std::uint32_t v = 0; v < named.mesh.vertex_count(); v += 41) {
                const Vec3 p = named.mesh.positions()[v];
                const auto free = find_free_position(surface, radius * size, p, scratch);
                ++asked;
                if (!free) continue;
                ++found;
                EXPECT_GE(distance_to(named.mesh, *free), radius * size * (1 - 1e-6) - skin)
                    << named.name << ' ' << radius << ' ' << v;
                EXPECT_LE((*free - p).norm(), free_position_radii * radius * size * (1 + 1e-5));
            }
        }
        // A soup may be too narrow here and there.
        EXPECT_GE(found, named.name == "soup" ? asked / 2 : asked) << named.name;
    }
}

TEST(FreePosition, NearAWallIsTheNearestOneOnTheSameSide)
{
    const TriangleMesh mesh = thin_plate(); // 1 mm, in 2 m
    const auto listed = *testing::listed_index(mesh);
    const IndexContactSurface surface(listed);
    SlideScratch scratch;
    for (const double side : {1.0, -1.0}) {
        const auto free =
            find_free_position(surface, 0.02, Vec3(0.31, 0.12, side * 0.003), scratch);
        ASSERT_TRUE(free);
        EXPECT_LT((*free - Vec3(0.31, 0.12, side * 0.0205)).norm(), 1e-6);
    }
    // Within the plate there is no room: beside it.
    const auto free = find_free_position(surface, 0.02, Vec3(0.31, 0.12, 0.0001), scratch);
    ASSERT_TRUE(free);
    EXPECT_NEAR(std::abs(free->z()), 0.0205, 1e-6);
}

/// Two slanted walls that meet below, each at half that angle.
TriangleMesh crevice(double angle)
{
    const double s = std::sin(angle / 2);
    const double c = std::cos(angle / 2);
    return mesh_of({Vec3(0, -5, 0), Vec3(0, 5, 0), Vec3(3 * s, 0, 3 * c), Vec3(-3 * s, 0, 3 * c)},
                   {{0, 1, 2}, {1, 0, 3}});
}

TEST(FreePosition, InACreviceIsAtItsMouth)
{
    constexpr double angle = 0.5236;
    const TriangleMesh mesh = crevice(angle);
    const auto listed = *testing::listed_index(mesh);
    const IndexContactSurface surface(listed);
    SlideScratch scratch;
    const double radius = 0.05;
    const double lowest = radius / std::sin(angle / 2); // where a sphere rests on both
    const auto free = find_free_position(surface, radius, Vec3(0, 0, 0.12), scratch);
    ASSERT_TRUE(free);
    EXPECT_LT((*free - Vec3(0, 0, lowest)).norm(), 1e-6);
}

TEST(FreePosition, FartherThanFourRadiiFromAMouthIsBesideAWall)
{
    constexpr double angle = 0.3;
    const TriangleMesh mesh = crevice(angle);
    const auto listed = *testing::listed_index(mesh);
    const IndexContactSurface surface(listed);
    SlideScratch scratch;
    const double radius = 0.05;
    const Vec3 p(0, 0, 2 * radius);
    ASSERT_GT(radius / std::sin(angle / 2) - p.z(), free_position_radii * radius);
    const auto free = find_free_position(surface, radius, p, scratch);
    ASSERT_TRUE(free);
    const double to_wall = p.z() * std::sin(angle / 2);
    EXPECT_NEAR((*free - p).norm(), to_wall + radius, 1e-6); // the nearest there is
    EXPECT_NEAR(distance_to(mesh, *free), radius, 1e-6);
}

/// Many plates, a little apart: nowhere is there room for a sphere of the size of the gaps.
TriangleMesh stack()
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (int i = -20; i <= 20; ++i) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (const double x : {-1.0, 1.0})
            for (const double y : {-1.0, 1.0}) positions.emplace_back(x, y, 0.01 * i);
        triangles.push_back({first, first + 1, first + 2});
        triangles.push_back({first + 1, first + 3, first + 2});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

TEST(Proxy, FeelsNothingWhereItDoesNotFit)
{
    const TriangleMesh mesh = stack();
    const auto listed = *testing::listed_index(mesh);
    const IndexContactSurface surface(listed);
    Proxy proxy(surface, {.radius = 0.02});
    proxy.place(Vec3(0, 0, 0.003));
    EXPECT_FALSE(proxy.last().is_placed);
    for (int tick = 0; tick < 300; ++tick) {
        const Vec3 device(0, 0, 0.003 + 1e-3 * tick);
        const ProxyTick& at = proxy.follow(device);
        EXPECT_EQ(at.hold, Hold::free);
        EXPECT_EQ(at.anchor, device);
        EXPECT_EQ(at.is_placed, device.z() > 0.22) << device.z();
        if (!at.is_placed) {
            EXPECT_TRUE(proxy.path().empty());
        }
    }
    // Out of it, it is held again.
    const ProxyTick& at = proxy.follow(Vec3(0, 0, 0.21));
    EXPECT_NEAR(at.anchor.z(), 0.22, 1e-9);
}

TEST(Proxy, IsNotStuckWhenItStartsInACornerOfTheShip)
{
    const TriangleMesh mesh = *sample_mesh("spaceship:1300");
    const Topology topology = *build_topology(mesh);
    const auto listed = *testing::listed_index(mesh);
    const IndexContactSurface surface(listed);
    const WorkspaceMap map = fit_workspace(bounding_box(mesh), 0.1);
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        const auto script = HandScript::make("corner", mesh, topology, map, seed);
        HapticRenderer renderer =
            make_surface_renderer(surface, map, *find_device("omni"), {.proxy_radius = 0.002});
        SimulatedHand hand({}, script->target(0));
        int moved = 0;
        int touching = 0;
        Vec3 last = Vec3::Zero();
        for (int tick = 0; tick < 700; ++tick) {
            const RenderTick& felt = renderer.tick(hand.state(), 1e-3);
            ASSERT_TRUE(felt.is_placed) << seed << ' ' << tick;
            ASSERT_GE(distance_to(mesh, felt.proxy),
                      parts_of(renderer).proxy().radius() * (1 - 1e-6));
            moved += felt.proxy != last ? 1 : 0;
            touching += felt.hold != Hold::free ? 1 : 0;
            last = felt.proxy;
            hand.step(felt.force, script->target(1e-3 * tick));
        }
        EXPECT_GT(moved, 250) << seed; // the others it sticks
        EXPECT_GT(touching, 20) << seed;
    }
}

} // namespace
} // namespace proxima::free_position_test
