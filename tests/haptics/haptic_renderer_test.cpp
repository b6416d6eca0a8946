#include "proxima/haptic_renderer.h"

#include "code_of.h"
#include "counted_allocations.h"
#include "folder_test.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/loop/recording.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "index/listed_index.h"
#include "lab/hand_script.h"
#include "lab/quality_report.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>

namespace proxima::haptic_renderer_test {
namespace {

constexpr double tick_seconds = 1e-3;

/// A model with all that a session needs.
struct Scene {
    explicit Scene(TriangleMesh model)
        : mesh(std::move(model)), topology(*build_topology(mesh)),
          listed(*testing::listed_index(mesh)), surface(listed),
          map(fit_workspace(bounding_box(mesh), 0.1))
    {}
    TriangleMesh mesh;
    Topology topology;
    MeshIndex listed;
    IndexContactSurface surface;
    WorkspaceMap map;
};

const DeviceLimits& omni()
{
    static const DeviceLimits limits = *find_device("omni");
    return limits;
}

DeviceState at(const Vec3& p)
{
    DeviceState state;
    state.pose.translation = p;
    return state;
}

/// A hand that follows a script for some ticks.
struct Session {
    QualityReport quality;
    Recording recording;
};

Session run(const Scene& scene, std::string_view script, std::uint64_t seed, int ticks,
            const RenderOptions& options)
{
    HapticRenderer renderer = make_surface_renderer(scene.surface, scene.map, omni(), options);
    const auto path = HandScript::make(script, scene.mesh, scene.topology, scene.map, seed);
    EXPECT_TRUE(path);
    SimulatedHand hand({}, path->target(0));
    QualityMeter meter(scene.surface, scene.map);
    Session session;
    session.recording.settings.map = scene.map;
    session.recording.settings.render = renderer.options();
    session.recording.settings.mesh_fingerprint = scene.listed.mesh_fingerprint();
    session.recording.ticks.reserve(static_cast<std::size_t>(ticks));
    const std::size_t allocations = testing::allocation_count();
    for (int tick = 0; tick < ticks; ++tick) {
        const DeviceState state = hand.state();
        const RenderTick& rendered = renderer.tick(state, tick_seconds);
        session.recording.ticks.push_back(recorded(tick * tick_seconds, state, rendered));
        meter.add(rendered, state.velocity, renderer.path());
        hand.step(rendered.force, path->target(tick * tick_seconds));
    }
    EXPECT_EQ(testing::allocation_count(), allocations);
    EXPECT_EQ(parts_of(renderer).passivity().report().softened_ticks, 0U)
        << script; // a hand that is damped
    session.quality = meter.report();
    return session;
}

TEST(HapticRenderer, TouchesAndHoldsInEveryScript)
{
    constexpr int ticks = 4000;
    for (const std::string_view model : {"cube", "sphere:30x30", "torus:24x12", "spaceship:1300"}) {
        const Scene scene(*sample_mesh(model));
        for (const std::string_view script :
             {"press", "slide", "stroke", "corner", "poke", "walk"}) {
            for (const double radius : {0.0, 0.002}) {
                // As far as it goes: how often it must be cut short says how well slides end.
                const QualityReport quality =
                    run(scene, script, 1, ticks,
                        {.proxy_radius = radius, .max_moves = max_slide_moves})
                        .quality;
                const std::string where =
                    std::string(model) + ' ' + std::string(script) + ' ' + std::to_string(radius);
                EXPECT_GT(quality.touching_ticks, 100U) << where;
                EXPECT_EQ(quality.passes, 0U) << where;
                EXPECT_EQ(quality.overloaded_ticks, 0U) << where;
                EXPECT_LT(quality.limited_ticks, ticks / 100U) << where; // one in a hundred
                EXPECT_EQ(quality.faulty_ticks, 0U) << where;
                EXPECT_LE(quality.max_force, omni().max_force) << where;
                EXPECT_GT(quality.max_spring, 0.1) << where;
            }
        }
    }
}

TEST(HapticRenderer, HoldsAFastPokeAtAThinPlate)
{
    const Scene scene(testing::thin_plate());
    const QualityReport quality = run(scene, "poke", 3, 8000, {}).quality;
    EXPECT_GT(quality.touching_ticks, 500U);
    EXPECT_GT(quality.max_speed, 0.3);
    EXPECT_EQ(quality.passes, 0U);
}

// Without friction and damping, what a slow closed path took it gives back.
TEST(HapticRenderer, ConservesEnergyOnClosedPathsAtAnalyticWalls)
{
    const Scene cube(*sample_mesh("cube"));
    const double k = 500;
    for (const double radius : {0.0, 0.004}) {
        RenderOptions options = {.force = {.stiffness = k,
                                           .damping = 0,
                                           .max_slew = 1e9,
                                           .start_seconds = 0,
                                           .loss_seconds = 0},
                                 .proxy_radius = radius,
                                 .static_friction = 0,
                                 .dynamic_friction = 0,
                                 .guard = Guard::off};
        HapticRenderer renderer = make_surface_renderer(cube.surface, cube.map, omni(), options);
        QualityMeter meter(cube.surface, cube.map);
        // An ellipse into the upper face and out again, from a point free of it back to it.
        const double top = 1 / cube.map.units_per_metre + radius;
        constexpr int ticks = 4000;
        Vec3 before = Vec3::Zero();
        for (int tick = 0; tick <= ticks; ++tick) {
            const double angle = 2 * std::numbers::pi * tick / ticks;
            const Vec3 p(0.006 * std::sin(angle), 0.003 * std::sin(2 * angle),
                         top + 0.005 * std::cos(angle));
            meter.add(renderer.tick(at(p), tick_seconds), (p - before) / tick_seconds,
                      renderer.path());
            before = p;
        }
        const double depth = meter.report().max_depth;
        EXPECT_NEAR(depth, 0.005, 1e-5);
        // Crossing the surface within a tick, the sum errs: by symmetry as much in as out.
        EXPECT_LT(std::abs(meter.report().taken_energy), 1e-9 * k * depth * depth);
        EXPECT_LE(meter.report().max_step_ratio, 1 + 1e-9);
    }
}

TEST(HapticRenderer, SticksWithinTheFrictionConeAndSlidesBeyond)
{
    const Scene cube(*sample_mesh("cube"));
    RenderOptions options = {.force = {.damping = 0, .max_slew = 1e9, .start_seconds = 0},
                             .guard = Guard::off};
    HapticRenderer renderer = make_surface_renderer(cube.surface, cube.map, omni(), options);
    const double top = 1 / cube.map.units_per_metre;
    renderer.tick(at(Vec3(0, 0, top + 0.001)), tick_seconds);
    renderer.tick(at(Vec3(0, 0, top - 0.001)), tick_seconds);
    const double depth = 0.001;
    // Sideways: sticking until 0.4 of the depth, the force leaning with the device.
    for (double x = 0; x < 0.4 * depth; x += 1e-5) {
        const RenderTick& rendered = renderer.tick(at(Vec3(x, 0, top - depth)), tick_seconds);
        EXPECT_EQ(rendered.hold, Hold::sticking);
        EXPECT_NEAR(rendered.force.x(), -500 * x, 1e-6);
        EXPECT_NEAR(rendered.force.z(), 500 * depth, 1e-6);
    }
    for (double x = 0.45 * depth; x < 3 * depth; x += 1e-5) {
        const RenderTick& rendered = renderer.tick(at(Vec3(x, 0, top - depth)), tick_seconds);
        EXPECT_EQ(rendered.hold, Hold::sliding);
        EXPECT_NEAR(rendered.force.x(), -0.3 * 500 * depth, 1e-6);
    }
    // Turning back, it holds still until it sticks the other way.
    const RenderTick& turned = renderer.tick(at(Vec3(2.8 * depth, 0, top - depth)), tick_seconds);
    EXPECT_EQ(turned.hold, Hold::sticking);
}

TEST(HapticRenderer, OnAnIndexFeelsLikeItsSurface)
{
    const Scene scene(*sample_mesh("torus:24x12"));
    HapticRenderer of_surface = make_surface_renderer(scene.surface, scene.map, omni());
    HapticRenderer first = make_haptic_renderer(scene.listed, scene.map, omni()).value();
    HapticRenderer of_index = std::move(first);
    const auto path = HandScript::make("stroke", scene.mesh, scene.topology, scene.map, 3);
    SimulatedHand hand({}, path->target(0));
    int corners = 0;
    const std::size_t allocations = testing::allocation_count();
    for (int tick = 0; tick < 4000; ++tick) {
        const DeviceState state = hand.state();
        const RenderTick& rendered = of_index.tick(state, tick_seconds);
        const RenderTick& same = of_surface.tick(state, tick_seconds);
        ASSERT_EQ(rendered.force, same.force) << tick;
        ASSERT_EQ(rendered.proxy, same.proxy) << tick;
        ASSERT_EQ(rendered.anchor, same.anchor) << tick;
        ASSERT_EQ(&rendered, &of_index.last());
        // The tick has what the proxy answered.
        const SlideResult& slide = parts_of(of_index).proxy_tick().slide;
        ASSERT_EQ(rendered.contact_count, slide.contact_count);
        for (std::size_t i = 0; i < rendered.contact_count; ++i) {
            ASSERT_EQ(rendered.contacts[i].position, slide.contacts[i].point);
            ASSERT_EQ(rendered.contacts[i].normal, slide.contacts[i].normal);
            ASSERT_EQ(rendered.contacts[i].triangle, slide.contacts[i].triangle);
            ASSERT_EQ(rendered.contacts[i].pressure, slide.contacts[i].pressure);
        }
        corners += rendered.contact_count > 1 ? 1 : 0;
        hand.step(rendered.force, path->target(tick * tick_seconds));
    }
    EXPECT_EQ(testing::allocation_count(), allocations);
    EXPECT_GT(corners, 10);
}

TEST(HapticRenderer, KeepsBadInputOutOfTheForce)
{
    const Scene scene(*sample_mesh("sphere:30x30"));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    HapticRenderer renderer = make_surface_renderer(scene.surface, scene.map, omni());
    const auto path = HandScript::make("slide", scene.mesh, scene.topology, scene.map, 2);
    SimulatedHand hand({}, path->target(0));
    std::mt19937 random(9);
    Vec3 last = Vec3::Zero();
    int faults = 0;
    for (int tick = 0; tick < 20000; ++tick) {
        DeviceState state = hand.state();
        switch (random() % 100) {
        case 0:
            state.pose.translation[random() % 3] = nan;
            break;
        case 1:
            state.pose.translation[random() % 3] = infinity;
            break;
        case 2:
            state.velocity[random() % 3] = nan;
            break;
        case 3:
            state.velocity *= 1e300;
            break;
        case 4:
            state.pose.translation += Vec3(1, 0, 0); // a jump of a metre
            break;
        case 5:
            state.pose.translation *= 1e200;
            break;
        default:
            break;
        }
        const RenderTick& rendered = renderer.tick(state, tick_seconds);
        ASSERT_TRUE(rendered.force.allFinite()) << tick;
        ASSERT_LE(rendered.force.norm(), omni().max_force) << tick;
        // After a jump the force rises from zero; all other changes are slow.
        if (rendered.fault != InputFault::jumped) {
            ASSERT_LE((rendered.force - last).norm(), 2000 * tick_seconds + 1e-12) << tick;
        }
        faults += rendered.fault != InputFault::none ? 1 : 0;
        last = rendered.force;
        hand.step(rendered.force, path->target(tick * tick_seconds));
    }
    EXPECT_GT(faults, 400);
}

TEST(HapticRenderer, DoesNotKickADeviceThatStartsInside)
{
    const Scene scene(*sample_mesh("cube"));
    HapticRenderer renderer = make_surface_renderer(scene.surface, scene.map, omni());
    for (int tick = 0; tick < 500; ++tick)
        EXPECT_EQ(renderer.tick(at(Vec3(0, 0, 1e-5 * tick)), tick_seconds).force, Vec3::Zero());
}

// Beginning inside a closed mesh, a device feels nothing until it has left it, and then its outside.
TEST(HapticRenderer, LetsADeviceOutThatBeginsInsideAClosedMesh)
{
    for (const char* const model : {"cube", "torus:24x12"}) {
        const Scene scene(*sample_mesh(model));
        for (const double radius : {0.0, 0.002}) {
            HapticRenderer renderer =
                make_haptic_renderer(scene.listed, scene.map, omni(), {.proxy_radius = radius})
                    .value();
            const auto within = scene.mesh.triangle(TriangleId{0});
            const Vec3 on = scene.map.to_device((within[0] + within[1] + within[2]) / 3);
            const Vec3 normal = scaled_normal(within).normalized();
            constexpr double deep = 0.006;
            constexpr int ticks = 400;
            const std::size_t allocations = testing::allocation_count();
            for (int tick = 0; tick <= ticks; ++tick) { // to 10 mm above the surface
                const double height = -deep + (deep + 0.010) * tick / ticks;
                const RenderTick& felt = renderer.tick(at(on + height * normal), tick_seconds);
                ASSERT_EQ(felt.force, Vec3::Zero()) << model << ' ' << radius << ' ' << tick;
                if (height < 0) {
                    ASSERT_FALSE(felt.is_placed) << model << ' ' << radius << ' ' << tick;
                }
            }
            EXPECT_TRUE(renderer.last().is_placed);
            for (int tick = 0; tick < 100; ++tick) // into it again
                renderer.tick(at(on + (0.010 - 0.00012 * tick) * normal), tick_seconds);
            EXPECT_EQ(testing::allocation_count(), allocations);
            EXPECT_GT(renderer.last().force.dot(normal), 0.5) << model << ' ' << radius;
        }
    }
}

TEST(HapticRenderer, StaysInsideAnOpenMeshThatHasNoInside)
{
    const TriangleMesh sphere = *sample_mesh("sphere:30x30");
    const Scene bowl(testing::without(sphere, [](std::size_t i) { return i % 900 < 100; }));
    HapticRenderer renderer = make_haptic_renderer(bowl.listed, bowl.map, omni()).value();
    const double wall = 1 / bowl.map.units_per_metre;
    for (int tick = 0; tick <= 500; ++tick) { // from within, 3 mm through the wall
        const double way = (wall + 0.003) * tick / 500;
        renderer.tick(at(bowl.map.to_device(Vec3::Zero()) + Vec3(0, 0, -way)), tick_seconds);
    }
    EXPECT_TRUE(renderer.last().is_placed);
    EXPECT_GT(renderer.last().force.z(), 1);
}

// No hand jumps so far: packets were lost. The device may be anywhere by now, but nothing was passed.
TEST(HapticRenderer, SweepsTheProxyOverAJump)
{
    struct Jump {
        TriangleMesh mesh;
        double past; ///< m, from the surface to where the device comes out
    };
    const Jump jumps[] = {{testing::thin_plate(), 0.03}, {*sample_mesh("cube"), 0.02}};
    for (const Jump& jump : jumps) {
        const Scene scene(jump.mesh);
        const double top = scene.map.to_device(bounding_box(scene.mesh).upper).z();
        for (const double radius : {0.0, 0.002}) {
            HapticRenderer renderer =
                make_surface_renderer(scene.surface, scene.map, omni(), {.proxy_radius = radius});
            QualityMeter meter(scene.surface, scene.map);
            const auto tick = [&](const Vec3& p) -> const RenderTick& {
                const RenderTick& felt = renderer.tick(at(p), tick_seconds);
                meter.add(felt, Vec3::Zero(), renderer.path());
                return felt;
            };
            const Vec3 above(0.001, 0.002, top + 0.04);
            const Vec3 below(0.004, -0.003, top - jump.past);
            for (int i = 0; i < 300; ++i) tick(above);
            EXPECT_EQ(tick(below).fault, InputFault::jumped);
            EXPECT_EQ(renderer.path().front(), scene.map.to_model(above));
            EXPECT_LT(renderer.last().force.norm(), 0.02 * omni().max_force);
            double before = renderer.last().force.norm();
            for (int i = 0; i < 300; ++i) {
                const double force = tick(below).force.norm();
                const double spring = renderer.last().spring.norm();
                const double rise = spring * tick_seconds / renderer.options().force.start_seconds;
                EXPECT_LE(force - before, rise * (1 + 1e-9));
                before = force;
            }
            EXPECT_NEAR(renderer.last().force.norm(), omni().max_force, 0.01);
            EXPECT_GT(renderer.last().force.z(), 3);
            EXPECT_NEAR(scene.map.to_device(renderer.last().proxy).z(), top + radius, 1e-6);
            EXPECT_EQ(meter.report().passes, 0U);
            // And back: it is free where it came from.
            EXPECT_EQ(tick(above).fault, InputFault::jumped);
            EXPECT_EQ(tick(above).hold, Hold::free);
        }
    }
}

// A jump is no motion on which the contact had given energy: nothing damps the hand after it.
TEST(HapticRenderer, AJumpWhileTheForceRampsUpAddsNoDamping)
{
    const Scene scene(*sample_mesh("cube"));
    const double top = scene.map.to_device(bounding_box(scene.mesh).upper).z();
    HapticRenderer renderer = make_surface_renderer(scene.surface, scene.map, omni(),
                                                    {.static_friction = 0, .dynamic_friction = 0});
    const auto tick = [&](double x, double depth, double speed) -> const RenderTick& {
        DeviceState state = at(Vec3(x, 0.002, top - depth));
        state.velocity.x() = speed;
        return renderer.tick(state, tick_seconds);
    };
    tick(0, -0.01, 0);
    for (int i = 0; i < 50; ++i) tick(0, 0.062, 0);
    EXPECT_GT(renderer.last().force.z(), 0.5);
    EXPECT_EQ(tick(0, 0.004, 0).fault, InputFault::jumped);
    for (int i = 1; i < 100; ++i) {
        const RenderTick& felt = tick(1e-4 * i, 0.004, 0.1);
        ASSERT_NE(felt.hold, Hold::free);
        ASSERT_NEAR(felt.force.x(), 0, 1e-9) << i;
    }
}

using RecordingTest = FolderTest;

TEST_F(RecordingTest, ReplaysBitForBit)
{
    const Scene scene(*sample_mesh("torus:24x12"));
    const Session session = run(scene, "walk", 5, 3000, {.proxy_radius = 0.001});
    EXPECT_GT(session.quality.touching_ticks, 100U);
    const auto path = folder() / "session.pxt";
    ASSERT_TRUE(save_recording(session.recording, path));
    auto loaded = load_recording(path);
    ASSERT_TRUE(loaded) << describe(loaded.error());
    EXPECT_EQ(loaded->ticks, session.recording.ticks);
    EXPECT_EQ(loaded->settings.mesh_fingerprint, scene.listed.mesh_fingerprint());
    EXPECT_EQ(loaded->settings.map.units_per_metre, scene.map.units_per_metre);
    EXPECT_EQ(loaded->settings.map.center, scene.map.center);
    EXPECT_EQ(loaded->settings.render.proxy_radius, 0.001);
    {
        HapticRenderer again = make_surface_renderer(scene.surface, loaded->settings.map, omni(),
                                                     loaded->settings.render);
        EXPECT_EQ(count_differences(*loaded, again), 0U);
    }
    // One bit of one position is noticed.
    double& x = loaded->ticks[1500].position[0];
    x = std::nextafter(x, 1.0);
    HapticRenderer again =
        make_surface_renderer(scene.surface, loaded->settings.map, omni(), loaded->settings.render);
    EXPECT_GT(count_differences(*loaded, again), 0U);
}

TEST_F(RecordingTest, KeepsTheModeOfTheGuard)
{
    const std::filesystem::path path = folder() / "mode.pxt";
    for (const Guard guard : {Guard::off, Guard::observe, Guard::on}) {
        Recording recording;
        recording.settings.render.guard = guard;
        ASSERT_TRUE(save_recording(recording, path));
        const auto loaded = load_recording(path);
        ASSERT_TRUE(loaded);
        EXPECT_EQ(loaded->settings.render.guard, guard);
    }
}

TEST(HapticRenderer, ResetsAsIfItWereNew)
{
    // A wall that swings, until it is damped; then the same motion twice, from a reset renderer and a
    // new one.
    const Scene cube(*sample_mesh("cube"));
    const double top = 1 / cube.map.units_per_metre;
    const auto run = [&](HapticRenderer& renderer) {
        std::vector<Vec3> forces;
        for (int tick = 0; tick < 1500; ++tick) {
            const double z = tick < 300 ? 0.002 : -0.001 + 5e-4 * std::sin(0.12 * tick);
            forces.push_back(renderer.tick(at(Vec3(0, 0, top + z)), tick_seconds).force);
        }
        return forces;
    };
    HapticRenderer renderer = make_surface_renderer(cube.surface, cube.map, omni(), {});
    const std::vector<Vec3> first = run(renderer);
    EXPECT_GT(parts_of(renderer).passivity().report().damped_ticks, 0U);
    EXPECT_GT(first.back().norm(), 0);
    renderer.reset();
    EXPECT_EQ(parts_of(renderer).passivity().report().damped_ticks, 0U);
    EXPECT_EQ(renderer.last().force, Vec3(Vec3::Zero()));
    EXPECT_EQ(run(renderer), first);
}

TEST_F(RecordingTest, RefusesDamagedFiles)
{
    Recording recording;
    recording.ticks.resize(10);
    const auto path = folder() / "session.pxt";
    ASSERT_TRUE(save_recording(recording, path));
    ASSERT_TRUE(load_recording(path));
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(700);
    file.put('x');
    file.close();
    const auto damaged = load_recording(path);
    ASSERT_FALSE(damaged);
    EXPECT_EQ(code_of(damaged), ErrorCode::malformed_file);
    recording.settings.render.dynamic_friction = 2; // more than the static one
    ASSERT_TRUE(save_recording(recording, path));
    EXPECT_EQ(code_of(load_recording(path)), ErrorCode::malformed_file);
    EXPECT_EQ(code_of(load_recording(folder() / "none.pxt")), ErrorCode::file_not_found);
}

TEST(HandScript, IsSmoothAndPeriodic)
{
    const Scene scene(*sample_mesh("spaceship:1300"));
    for (const std::string_view name : {"press", "slide", "stroke", "corner", "poke", "walk"}) {
        const auto script = HandScript::make(name, scene.mesh, scene.topology, scene.map, 4);
        const auto again = HandScript::make(name, scene.mesh, scene.topology, scene.map, 4);
        const auto other = HandScript::make(name, scene.mesh, scene.topology, scene.map, 5);
        ASSERT_TRUE(script && again && other);
        EXPECT_LT((script->target(script->period()) - script->target(0)).norm(), 1e-12);
        double differ = 0;
        for (double t = 0; t < 2 * script->period(); t += 1e-3) {
            EXPECT_LT((script->target(t + 1e-3) - script->target(t)).norm(), 0.005) << name << t;
            EXPECT_EQ(script->target(t), again->target(t));
            differ = std::max(differ, (script->target(t) - other->target(t)).norm());
        }
        if (name != "corner") {
            EXPECT_GT(differ, 1e-3) << name;
        }
    }
    const auto wrong = HandScript::make("hit", scene.mesh, scene.topology, scene.map, 1);
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().message.find("press"), std::string::npos);
}

} // namespace
} // namespace proxima::haptic_renderer_test
