#include "haptics/surface/shading_normals.h"

#include "haptics/force/surface_renderer.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scenes_to_touch.h"
#include "haptics/surface/contact_surface.h"
#include "index/listed_index.h"
#include "lab/hand_script.h"
#include "lab/quality_report.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace proxima::shading_normals_test {
namespace {

using namespace testing;

double angle_between(const Vec3& a, const Vec3& b)
{
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

TEST(ShadingNormals, RoundASphereAndNotACube)
{
    const TriangleMesh sphere = *sample_mesh("icosphere:2");
    const ShadingNormals round(sphere, *build_topology(sphere));
    for (std::uint32_t id = 0; id < sphere.triangle_count(); ++id) {
        const Triangle triangle = sphere.triangle(TriangleId{id});
        for (int k = 0; k < 3; ++k) {
            const Vec3 normal = round.shaded_normal(TriangleId{id}, triangle[k]);
            EXPECT_LT(angle_between(normal, triangle[k]), 0.02) << id;
            const Vec3 middle = 0.5 * (triangle[k] + triangle[(k + 1) % 3]);
            EXPECT_LT(angle_between(round.shaded_normal(TriangleId{id}, middle), middle), 0.02);
        }
    }
    const TriangleMesh cube = *sample_mesh("cube");
    const ShadingNormals flat(cube, *build_topology(cube));
    for (std::uint32_t id = 0; id < cube.triangle_count(); ++id) {
        const Triangle triangle = cube.triangle(TriangleId{id});
        const Vec3 face = scaled_normal(triangle).normalized();
        for (int k = 0; k < 3; ++k)
            EXPECT_LT((flat.shaded_normal(TriangleId{id}, triangle[k]) - face).norm(), 1e-14);
    }
}

TEST(ShadingNormals, AreTheSameFromBothSidesOfASmoothEdge)
{
    for (const char* const name : {"torus:24x12", "spaceship:1300", "sphere:12x12"}) {
        const TriangleMesh mesh = *sample_mesh(name);
        const Topology topology = *build_topology(mesh);
        const ShadingNormals normals(mesh, topology);
        int smooth = 0;
        for (std::uint32_t id = 0; id < topology.edge_count(); ++id) {
            const auto sides = topology.triangles(EdgeId{id});
            if (sides.size() != 2) continue;
            const double turn = angle_between(scaled_normal(mesh.triangle(sides[0])),
                                              scaled_normal(mesh.triangle(sides[1])));
            if (turn > 0.74) continue;
            ++smooth;
            const auto [from, to] = topology.vertices(EdgeId{id});
            for (const double part : {0.0, 0.3, 1.0}) {
                const Vec3 p =
                    mesh.position(from) + part * (mesh.position(to) - mesh.position(from));
                EXPECT_LT((normals.shaded_normal(sides[0], p) - normals.shaded_normal(sides[1], p))
                              .norm(),
                          1e-6)
                    << name << ' ' << id;
            }
        }
        EXPECT_GT(smooth, 100) << name;
    }
}

/// Round a coarse sphere, a little deep: how far the force is off the smooth normal, and how
/// much it turns in a tick.
struct Roundness {
    double off = 0;
    double turn = 0;
    double depth = 0; ///< off the depth below the facets, over it
};

Roundness stroke_round(ForceShading shading, double radius)
{
    const TriangleMesh mesh = *sample_mesh("icosphere:2"); // 320 triangles
    const Topology topology = *build_topology(mesh);
    const auto listed = *testing::listed_index(mesh);
    const IndexContactSurface surface(listed);
    const ShadingNormals normals(mesh, topology);
    Proxy proxy(surface, {.radius = radius, .shading = shading, .properties = &normals});
    proxy.place(Vec3(2, 0, 0));
    Roundness result;
    Vec3 last = Vec3::Zero();
    double last_turn = 0;
    for (int tick = 0; tick < 6000; ++tick) {
        const double turn = std::numbers::pi * 2 * tick / 6000;
        const Vec3 direction =
            Vec3(std::cos(turn), std::sin(turn), 0.3 * std::sin(3 * turn)).normalized();
        const Vec3 device = (0.97 + radius) * direction;
        const ProxyTick& at = proxy.follow(device);
        const Vec3 force = at.anchor - device;
        if (tick > 100) {
            result.off = std::max(result.off, angle_between(force, direction));
            result.turn = std::max(result.turn, angle_between(force, last) - last_turn);
            result.depth = std::max(result.depth, std::abs(force.norm() / at.depth - 1));
            EXPECT_NEAR(force.dot(at.normal) / at.depth, 1, 1e-9) << tick;
        }
        const double next = std::numbers::pi * 2 * (tick + 1) / 6000;
        const Vec3 next_direction =
            Vec3(std::cos(next), std::sin(next), 0.3 * std::sin(3 * next)).normalized();
        last_turn = angle_between(direction, next_direction);
        last = force;
    }
    return result;
}

TEST(ForceShading, MakesACoarseSphereFeelRoundAtTheSameDepth)
{
    for (const double radius : {0.0, 0.05}) {
        const Roundness plain = stroke_round(ForceShading::off, radius);
        const Roundness shaded = stroke_round(ForceShading::on, radius);
        std::printf("radius %g: off the round normal by %.1f degrees, shaded %.1f; turns by %.2f, "
                    "shaded %.2f in a tick; force over depth off by %.3f\n",
                    radius, plain.off * 57.3, shaded.off * 57.3, plain.turn * 57.3,
                    shaded.turn * 57.3, shaded.depth);
        EXPECT_LT(shaded.off, 0.45 * plain.off) << radius;
        EXPECT_LT(shaded.turn, 0.01) << radius;
        EXPECT_LT(shaded.depth, 0.06);
    }
}

TEST(ForceShading, PassesThroughNothingAndGeneratesNoEnergy)
{
    for (const char* const name : {"icosphere:1", "torus:12x8", "spaceship:1300"}) {
        const TriangleMesh mesh = *sample_mesh(name);
        const Topology topology = *build_topology(mesh);
        const auto listed = *testing::listed_index(mesh);
        const IndexContactSurface surface(listed);
        const ShadingNormals normals(mesh, topology);
        const WorkspaceMap map = fit_workspace(bounding_box(mesh), 0.1);
        const DeviceLimits omni = *find_device("omni");
        for (const char* const script_name : {"slide", "stroke", "poke", "walk"}) {
            for (const double radius : {0.0, 0.002}) {
                const auto script = HandScript::make(script_name, mesh, topology, map, 2);
                HapticRenderer renderer = make_surface_renderer(
                    surface, map, omni, {.proxy_radius = radius, .shading = ForceShading::on},
                    &normals);
                SimulatedHand hand({}, script->target(0));
                QualityMeter meter(surface, map);
                double energy = 0; // J, taken in this contact
                double lowest = 0;
                bool touched = false;
                Vec3 before = Vec3::Zero();
                Vec3 position = Vec3::Zero();
                for (int tick = 0; tick < 2500; ++tick) {
                    const DeviceState state = hand.state();
                    const RenderTick& felt = renderer.tick(state, 1e-3);
                    meter.add(felt, state.velocity, renderer.path());
                    ASSERT_TRUE(felt.force.allFinite());
                    hand.step(felt.force, script->target(1e-3 * tick));
                    // Of the steps between two ticks in contact.
                    if (felt.hold == Hold::free) energy = 0;
                    if (touched && felt.hold != Hold::free)
                        energy -= before.dot(state.pose.translation - position);
                    touched = felt.hold != Hold::free;
                    before = felt.force;
                    position = state.pose.translation;
                    lowest = std::min(lowest, energy);
                }
                const QualityReport& quality = meter.report();
                EXPECT_EQ(quality.passes, 0U) << name << ' ' << script_name;
                EXPECT_GT(quality.touching_ticks, 50U) << name << ' ' << script_name;
                EXPECT_GT(lowest, -2e-4) << name << ' ' << script_name;
                EXPECT_LT(quality.max_speed, 3) << name << ' ' << script_name;
            }
        }
    }
}

} // namespace
} // namespace proxima::shading_normals_test
