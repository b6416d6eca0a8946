// Tools that are driven into objects from anywhere, turning: they enter nothing and pass nothing.
#include "haptics/tool/every_pair.h"
#include "haptics/tool/rigid_motion.h"
#include "haptics/tool/tool_bench.h"
#include "haptics/touch_meshes.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "proxima/tool_renderer.h"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace proxima::testing::tool_approaches_test {
namespace {

constexpr double clearance = 1e-5;

struct NamedMesh {
    std::string name;
    TriangleMesh mesh;
};

TriangleMesh scaled(const TriangleMesh& mesh, const Vec3& factors)
{
    return moved(mesh, [&](const Vec3& p) { return Vec3(factors.cwiseProduct(p)); });
}

/// A needle with a base of 1 mm and 2 cm length, its tip up.
TriangleMesh spike()
{
    return mesh_of({{-5e-4, -5e-4, 0}, {5e-4, -5e-4, 0}, {0, 5e-4, 0}, {0, 0, 0.02}},
                   {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
}

std::vector<NamedMesh> tools()
{
    return {{"box", box_mesh({0.008, 0.005, 0.003})},
            {"ball", scaled(*sample_mesh("icosphere:2"), Vec3::Constant(0.006))},
            {"spike", moved(spike(), [](const Vec3& p) { return Vec3(p - Vec3(0, 0, 0.02)); })},
            {"sheet", scaled(bumpy_sheet(6), Vec3::Constant(0.01))},
            {"blade", box_mesh({0.01, 0.006, 2e-5})}};
}

std::vector<NamedMesh> objects()
{
    return {{"cube", box_mesh(Vec3::Constant(0.02))},
            {"thin plate", box_mesh({0.02, 0.02, 5e-5})},
            {"spike", spike()},
            {"torus", scaled(*sample_mesh("torus:24x12"), Vec3::Constant(0.02))},
            {"corner", scaled(inner_corner(0), Vec3::Constant(0.02))},
            {"sheet", scaled(bumpy_sheet(16), Vec3::Constant(0.02))},
            {"soup", scaled(triangle_soup(3, 40), Vec3::Constant(0.02))},
            {"spaceship", scaled(*sample_mesh("spaceship:1300"), Vec3::Constant(0.004))}};
}

/// Looks at all poses along the path of a tick, in steps below `step`.
void expect_nothing_passed(const ToolBench& bench, const MeshIndex& tool, const MeshIndex& object,
                           double reach, double step)
{
    const auto path = bench.renderer().path();
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
        const Twist twist = twist_between(path[i], path[i + 1]);
        const int parts = 1 + static_cast<int>(twist.path_length(reach) / step);
        for (int part = 1; part <= parts; ++part) {
            const RigidTransform pose = moved_by(path[i], twist, part / static_cast<double>(parts));
            const auto near = mesh_distance(object, tool, pose, {.farthest = clearance});
            // The shortest distance is kept up to rounding of the poses.
            const double distance = near ? near->distance : clearance;
            ASSERT_GT(distance, 0.5 * clearance - 1e-9);
        }
    }
    ASSERT_FALSE(bench.meets());
}

class ToolApproaches : public ::testing::TestWithParam<std::size_t> {};

TEST_P(ToolApproaches, PassNothing)
{
    const NamedMesh object = objects()[GetParam()];
    SCOPED_TRACE(object.name);
    const MeshIndex object_index = index_of(object.mesh);
    int touches = 0;
    std::uint32_t seed = 100 * static_cast<std::uint32_t>(GetParam());
    for (const NamedMesh& tool : tools()) {
        const MeshIndex tool_index = index_of(tool.mesh);
        double reach = 0;
        for (const Vec3& p : tool.mesh.positions()) reach = std::max(reach, p.norm());
        // Without friction and with it.
        for (int approach = 0; approach < 2; ++approach) {
            ++seed;
            SCOPED_TRACE(tool.name + ", seed " + std::to_string(seed));
            Random random(seed);
            ToolBench bench(tool.mesh, {{object_index, {}}},
                            springs_with_friction(0.5 * approach, 0.4 * approach));
            RigidTransform device = pose_at(0.07 * random.direction(), 3 * random.direction());
            bench.start(device);
            ASSERT_TRUE(bench.renderer().last().is_placed);
            // Through the middle and out on the other side, up to 1 m/s and 15 rad/s.
            const Vec3 goal = 0.01 * random.direction() - 0.6 * device.translation;
            const double speed = random(0.3e-3, 1e-3);
            const Vec3 spin = random(0, 15e-3) * random.direction();
            const Vec3 velocity = speed * (goal - device.translation).normalized();
            const int ticks = static_cast<int>((goal - device.translation).norm() / speed);
            for (int tick = 0; tick < ticks; ++tick) {
                device.translation += velocity;
                device = moved_by(device, {Vec3::Zero(), spin}, 1);
                const ToolTick& felt = bench.tick(device);
                touches += felt.contact_count > 0 ? 1 : 0;
                ASSERT_TRUE(felt.force.allFinite() && felt.torque.allFinite());
                expect_nothing_passed(bench, tool_index, object_index, reach, 2e-4);
                if (HasFatalFailure()) return;
            }
        }
    }
    std::cout << object.name << ": " << touches << " ticks in contact\n";
    EXPECT_GT(touches, 100);
}

/// Scans, fitted into a box of 10 cm, where there are any.
std::vector<NamedMesh> scans()
{
    const std::filesystem::path shared =
        std::filesystem::path(PROXIMA_SOURCE_DIR) / ".." / "shared" / "meshes";
    const std::filesystem::path debian = "/usr/share/glmark2/models";
    std::vector<NamedMesh> found;
    for (const auto& path : {shared / "dragon_vrip_res3.ply", shared / "fandisk.obj",
                             debian / "bunny.obj", debian / "cat.3ds"}) {
        auto mesh = read_mesh(path);
        if (!mesh) continue;
        const Box box = bounding_box(*mesh);
        const double scale = 0.1 / box.extent().maxCoeff();
        found.push_back({path.filename().string(), moved(*mesh, [&](const Vec3& p) {
                             return Vec3(scale * (p - box.center()));
                         })});
    }
    return found;
}

/// Random approaches to points of scans, from outside through the surface, turning, and back again.
TEST(ToolApproachesToScans, PassNothing)
{
    const std::vector<NamedMesh> found = scans();
    std::uint32_t seed = 5000;
    for (const NamedMesh& scan : found) {
        const MeshIndex index = index_of(scan.mesh);
        const std::vector<BoxedTriangle> all = boxed(scan.mesh);
        int touches = 0;
        double nearest = 1;
        for (const NamedMesh& tool : tools()) {
            double reach = 0;
            for (const Vec3& p : tool.mesh.positions()) reach = std::max(reach, p.norm());
            ++seed;
            SCOPED_TRACE(scan.name + ", " + tool.name + ", seed " + std::to_string(seed));
            Random random(seed);
            const double friction = seed % 2 == 0 ? 0 : 0.5; // without and with it
            ToolBench bench(tool.mesh, {{index, {}}},
                            springs_with_friction(friction, 0.8 * friction));
            const auto id = static_cast<std::uint32_t>(
                random(0, static_cast<double>(scan.mesh.triangle_count())));
            const Triangle aim = scan.mesh.triangle(TriangleId{id});
            const Vec3 outward = scaled_normal(aim).normalized() + 0.5 * random.direction();
            RigidTransform device =
                pose_at(aim[0] + 0.11 * outward.normalized(), 3 * random.direction());
            bench.start(device);
            if (!bench.renderer().last().is_placed) continue; // begins in another part
            const double speed = random(0.3e-3, 1e-3);
            const Vec3 spin = random(0, 15e-3) * random.direction();
            const Vec3 velocity = -speed * outward.normalized();
            const int ticks = static_cast<int>(0.125 / speed);
            for (int tick = 0; tick < 2 * ticks; ++tick) {
                device.translation += tick < ticks ? velocity : Vec3(-velocity);
                device = moved_by(device, {Vec3::Zero(), spin}, 1);
                const ToolTick& felt = bench.tick(device);
                touches += felt.contact_count > 0 ? 1 : 0;
                const auto path = bench.renderer().path();
                double length = 0;
                for (std::size_t i = 0; i + 1 < path.size(); ++i)
                    length += twist_between(path[i], path[i + 1]).path_length(reach);
                const auto near =
                    near_ball(all, path.front().translation, reach + length + 2 * clearance);
                if (near.empty()) continue;
                for (std::size_t i = 0; i + 1 < path.size(); ++i) {
                    const Twist twist = twist_between(path[i], path[i + 1]);
                    const int parts = 1 + static_cast<int>(twist.path_length(reach) / 1e-3);
                    for (int part = 1; part <= parts; ++part) {
                        const RigidTransform pose =
                            moved_by(path[i], twist, part / static_cast<double>(parts));
                        const double distance =
                            distance_of(near, boxed(tool.mesh, pose), 2 * clearance);
                        nearest = std::min(nearest, distance);
                        ASSERT_GT(distance, 0.5 * clearance - 1e-9) << "tick " << tick;
                    }
                }
            }
        }
        std::cout << scan.name << ": " << touches << " ticks in contact, no nearer than "
                  << 1e6 * nearest << " um\n";
        EXPECT_GT(touches, 100);
    }
    if (found.empty()) GTEST_SKIP() << "install glmark2-data: without it there are no scans";
}

INSTANTIATE_TEST_SUITE_P(Objects, ToolApproaches, ::testing::Range(std::size_t{0}, std::size_t{8}));

} // namespace
} // namespace proxima::testing::tool_approaches_test
