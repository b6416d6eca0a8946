// Textures against closed forms, and that they change nothing where they are off.
#include "counted_allocations.h"
#include "folder_test.h"
#include "haptics/force/surface_texture.h"
#include "haptics/height_images.h"
#include "haptics/loop/recording.h"
#include "haptics/spring_alone.h"
#include "haptics/surface/height_field.h"
#include "haptics/surface/wave.h"
#include "haptics/textured_table.h"
#include "haptics/touch_meshes.h"
#include "lab/simulated_hand.h"
#include "octree/small_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "proxima/touch_scene.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace proxima::surface_texture_test {
namespace {

using namespace testing;

TEST(Wave, IsSineCosineAndDecay)
{
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> turns(-20, 20);
    for (int i = 0; i < 10000; ++i) {
        const double t = turns(random);
        const double angle = 2 * std::numbers::pi * (t - std::floor(t));
        EXPECT_NEAR(wave_at(t).sine, std::sin(angle), 4e-15) << t;
        EXPECT_NEAR(wave_at(t).cosine, std::cos(angle), 4e-15) << t;
        const double x = 32 + 1.6 * t;
        EXPECT_NEAR(decay_of(x) / std::exp(-x), 1, 1e-12) << x;
    }
    EXPECT_EQ(wave_at(0.75).sine, -1);
    EXPECT_EQ(decay_of(0), 1);
}

TEST(HeightField, SlopeIsTheGradientAndCurvatureIsBounded)
{
    const std::uint64_t seed = 7;
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(-0.05, 0.05);
    for (const BumpShape shape : {BumpShape::grating, BumpShape::dimples, BumpShape::noise}) {
        const Bump bump = {
            .shape = shape, .amplitude = 1e-4, .wavelength = 0.003, .direction = Vec3(1, 2, -0.5)};
        // A soft surface on a device of no force: the slope alone limits the amplitude.
        DeviceLimits weak = omni;
        weak.max_force = 1e-12;
        const double steepest = bump.amplitude / most_amplitude(bump, 0, weak);
        // One of no stiffness: the curvature alone.
        const double curved =
            bump.amplitude * omni.max_stiffness / most_amplitude(bump, 0, omni) / omni.max_force;
        double steep = 0;
        double bent = 0;
        for (int i = 0; i < 3000; ++i) {
            const Vec3 p(place(random), place(random), place(random));
            const Groove groove = groove_at(bump, p);
            EXPECT_GE(groove.depth, 0);
            EXPECT_LE(groove.depth, 2 * bump.amplitude * (1 + 1e-15));
            Mat3 hessian;
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                constexpr double h = 1e-6;
                const Groove up = groove_at(bump, p + h * Vec3::Unit(axis));
                const Groove down = groove_at(bump, p - h * Vec3::Unit(axis));
                EXPECT_NEAR((up.depth - down.depth) / (2 * h), groove.slope[axis], 1e-5 * steepest);
                hessian.col(axis) = (up.slope - down.slope) / (2 * h);
            }
            steep = std::max(steep, groove.slope.norm());
            bent = std::max(bent, hessian.operatorNorm());
        }
        EXPECT_LE(steep, steepest * (1 + 1e-9)) << static_cast<int>(shape);
        EXPECT_LE(bent, curved * (1 + 1e-3)) << static_cast<int>(shape);
        // The bounds are no more than six times what is met.
        EXPECT_GE(6 * steep, steepest) << static_cast<int>(shape);
        EXPECT_GE(6 * bent, curved) << static_cast<int>(shape);
    }
}

/// Lengths of textures are the device's, whatever the model's unit is.
constexpr std::array<double, 2> model_units = {1, 20}; // to a metre of the device

TEST(SurfaceTexture, GratingPushesAsItsClosedForm)
{
    const double amplitude = 6e-5;
    const double wavelength = 0.004;
    const Vec3 along = Vec3(3, 4, 0) / 5;
    const SurfaceTexture texture = {.bump = {.shape = BumpShape::grating,
                                             .amplitude = amplitude,
                                             .wavelength = wavelength,
                                             .direction = 2 * along}};
    for (const double units : model_units) {
        Table table(with_texture(texture, spring_alone(stiffness)), omni, units);
        ASSERT_EQ(table.renderer().options().texture.bump.amplitude, amplitude); // not limited
        table.rest(Vec3(0, 0, 0.001));
        const double k = 2 * std::numbers::pi / wavelength;
        double greatest = 0;
        int in_grooves = 0;
        for (int tick = 0; tick < 4000; ++tick) {
            const double x = 1e-5 * tick;
            const double depth = 0.001 * (1 - std::cos(1e-3 * tick)); // from 0 on: into the grooves
            const RenderTick& felt = table.go(x * along + Vec3(0.001, -0.00075, -depth));
            const double left = std::max(depth - amplitude * (1 - std::cos(k * x)), 0.0);
            const Vec3 expected = stiffness * left * Vec3::UnitZ() +
                                  stiffness * left * amplitude * k * std::sin(k * x) * along;
            EXPECT_LT((felt.force - expected).norm(), 1e-6) << units << ' ' << tick;
            greatest = std::max(greatest, std::abs(felt.force.dot(along)));
            in_grooves += depth > 1e-6 && left == 0 ? 1 : 0;
        }
        EXPECT_GT(greatest, 0.05);
        EXPECT_GT(in_grooves, 20);
    }
}

TEST(SurfaceTexture, ImagePushesAsItsGroovesAndAllocatesNothing)
{
    constexpr double amplitude = 5e-5;
    constexpr double wavelength = 0.012;
    // Two waves along a diagonal: up in the picture is y, and the first row is on top.
    const HeightImage image = testing::image_of(48, 48, [](double column, double row) {
        return 0.5 + 0.5 * std::cos(2 * std::numbers::pi * (column + 2 * row));
    });
    const SurfaceTexture texture = {.bump = {.shape = BumpShape::image,
                                             .amplitude = amplitude,
                                             .wavelength = wavelength,
                                             .direction = Vec3::UnitZ(),
                                             .image = image}};
    Table table(with_texture(texture, spring_alone(stiffness)));
    ASSERT_EQ(table.renderer().options().texture.bump.amplitude, amplitude); // not limited
    table.rest(Vec3(0, 0, 0.001));
    const Vec3 k = 2 * std::numbers::pi / wavelength * Vec3(1, -2, 0);
    // Of a wave of n pixels the fourth power of sinc is left; aliases add less than a thousandth.
    const auto left_of = [](double n) {
        const double x = std::numbers::pi / n;
        return std::pow(std::sin(x) / x, 4);
    };
    const double part = left_of(48) * left_of(24);
    const std::size_t allocations = testing::allocation_count();
    double greatest = 0;
    int in_grooves = 0;
    for (int tick = 0; tick < 4000; ++tick) {
        const double depth = 0.001 * (1 - std::cos(1e-3 * tick)); // from 0 on: into the grooves
        const Vec3 at(1e-5 * tick, -7e-6 * tick, -depth);
        const RenderTick& felt = table.go(at);
        const double left = depth - amplitude * (1 - part * std::cos(k.dot(at)));
        const Vec3 expected =
            left > 0 ? Vec3(stiffness * left *
                            (Vec3::UnitZ() + amplitude * part * std::sin(k.dot(at)) * k))
                     : Vec3(Vec3::Zero());
        ASSERT_LT((felt.force - expected).norm(), 1e-4 + 1e-3 * expected.norm()) << tick;
        greatest = std::max(greatest, felt.force.head<2>().norm());
        in_grooves += depth > 1e-6 && left < 0 ? 1 : 0;
    }
    ASSERT_EQ(testing::allocation_count(), allocations);
    EXPECT_GT(greatest, 0.05);
    EXPECT_GT(in_grooves, 20);
}

TEST(SurfaceTexture, FrictionCountsThePressureThatIsLeft)
{
    constexpr double amplitude = 6e-5;
    constexpr double depth = 1.5e-4;
    RenderOptions options = spring_alone(stiffness);
    options.static_friction = 0.4;
    options.dynamic_friction = 0.3;
    options.texture.bump = {
        .shape = BumpShape::grating, .amplitude = amplitude, .wavelength = 0.004};
    // Along a crest, half way down, and along the ground of a groove.
    for (const double x : {0.0, 0.001, 0.002}) {
        Table table(options);
        table.rest(Vec3(x, 0, 0.001));
        table.go(Vec3(x, 0, -depth));
        for (int tick = 1; tick <= 200; ++tick) table.go(Vec3(x, 2e-5 * tick, -depth));
        const double groove = amplitude * (1 - std::cos(2 * std::numbers::pi * x / 0.004));
        const Vec3 force = table.renderer().last().force;
        EXPECT_NEAR(force.z(), stiffness * (depth - groove), 1e-6) << x;
        EXPECT_NEAR(force.y(), -0.3 * stiffness * (depth - groove), 1e-6) << x;
    }
}

TEST(SurfaceTexture, AmplitudeIsLimitedByStiffnessWavelengthAndDevice)
{
    // K s^2 A^2 + F c A = K max, with s = 2 pi / L and c = s^2.
    for (const double wavelength : {5e-4, 0.002, 0.02, 0.5}) {
        const Bump bump = {
            .shape = BumpShape::grating, .amplitude = 0.01, .wavelength = wavelength};
        const double a = most_amplitude(bump, stiffness, omni);
        const double s = 2 * std::numbers::pi / wavelength;
        const double added = stiffness * s * s * a * a + omni.max_force * s * s * a;
        EXPECT_LE(added, omni.max_stiffness * (1 + 1e-9)) << wavelength;
        EXPECT_LE(s * a, 1 + 1e-9) << wavelength;
        EXPECT_TRUE(s * a > 0.999 || added > 0.999 * omni.max_stiffness) << wavelength;
        Table table(with_texture({.bump = bump}, spring_alone(stiffness)));
        EXPECT_EQ(table.renderer().options().texture.bump.amplitude, std::min(a, 0.01));
    }
}

TEST(SurfaceTexture, ViscosityIsAgainstTheMotionAlongTheSurface)
{
    RenderOptions options = spring_alone(stiffness);
    options.force.damping = 1;
    options.texture.viscosity = 1.2;
    Table table(options);
    table.rest(Vec3(0, 0, 0.001));
    EXPECT_EQ(table.go(Vec3(0.001, 0, 0.001)).force, Vec3::Zero()); // not in the air
    Vec3 at(0.001, 0, -0.002);
    table.go(at);
    for (const Vec3& v : {Vec3(0.1, 0, 0), Vec3(-0.03, 0.04, -0.05), Vec3(0, 0, -0.1)}) {
        at += tick_seconds * v;
        const Vec3 expected(-1.2 * v.x(), -1.2 * v.y(), -stiffness * at.z() - 1 * v.z());
        EXPECT_LT((table.go(at).force - expected).norm(), 1e-6);
    }
    options.texture.viscosity = 1000;
    EXPECT_EQ(Table(options).renderer().options().texture.viscosity, omni.max_damping / 4);
}

TEST(SurfaceTexture, StickSlipIsASawtooth)
{
    RenderOptions options = spring_alone(stiffness);
    options.texture.stick_slip = {.stiffness = 150, .max_force = 0.5};
    for (const double units : model_units) {
        Table table(options, omni, units);
        table.rest(Vec3(0, 0, 0.001));
        double stick = 0;
        std::uint64_t slips = 0;
        for (int tick = 0; tick < 200; ++tick) {
            const double x = 7e-5 * tick;
            const RenderTick& felt = table.go(Vec3(x, 0, -0.002));
            if (150 * (x - stick) > 0.5) {
                stick = x;
                ++slips;
            }
            EXPECT_LT((felt.force - Vec3(-150 * (x - stick), 0, stiffness * 0.002)).norm(), 1e-6)
                << units << ' ' << tick;
        }
        EXPECT_GE(slips, 4U);
        EXPECT_EQ(table.report().slips, slips);
        // It sticks anew where it touches again.
        table.go(Vec3(0.02, 0, 0.001));
        table.go(Vec3(0.021, 0, -0.002));
        EXPECT_LT((table.go(Vec3(0.022, 0, -0.002)).force - Vec3(-0.15, 0, 1)).norm(), 1e-6);
    }
}

/// The spring of a cube's upper face, z = 0, of a body with that texture, along a way.
std::vector<Vec3> springs_of_body(const SurfaceTexture& texture, const std::vector<Vec3>& way)
{
    TouchScene scene(Box{Vec3(-9, -9, -9), Vec3(9, 9, 9)});
    const auto body = build_touch_body(cube_mesh(Vec3(0, 0, -0.5), 0.5), {.texture = texture});
    EXPECT_TRUE(scene.add(*body, {}));
    auto renderer =
        make_haptic_renderer(scene, {1, Vec3::Zero()}, omni, spring_alone(stiffness)).value();
    std::vector<Vec3> springs;
    for (const Vec3& p : way) springs.push_back(renderer.tick(state_at(p), tick_seconds).spring);
    return springs;
}

TEST(SurfaceTexture, TexturesOfBodiesAreLimitedByTheDevice)
{
    // A quarter of the stiffness of an omni, and its greatest force: it slips beyond 18.86 mm.
    const SurfaceTexture rubber = {.stick_slip = {.stiffness = 1e6, .max_force = 1e6}};
    const auto pulls = springs_of_body(rubber, {Vec3(0, 0, 0.001), Vec3(0, 0, -0.002),
                                                Vec3(0.018, 0, -0.002), Vec3(0.019, 0, -0.002)});
    EXPECT_LT((pulls[2] - Vec3(-0.25 * 700 * 0.018, 0, stiffness * 0.002)).norm(), 1e-6);
    EXPECT_LT((pulls[3] - Vec3(0, 0, stiffness * 0.002)).norm(), 1e-6);
    // K s^2 A^2 + F s^2 A = K max, as AmplitudeIsLimitedByStiffnessWavelengthAndDevice has it; half way
    // down into a groove.
    const double wavelength = 0.02;
    const SurfaceTexture plough = {
        .bump = {.shape = BumpShape::grating, .amplitude = 0.01, .wavelength = wavelength}};
    const double s = 2 * std::numbers::pi / wavelength;
    const double push = omni.max_force / (2 * stiffness);
    const double amplitude =
        std::sqrt(push * push + omni.max_stiffness / (stiffness * s * s)) - push;
    constexpr double depth = 0.004;
    const double left = depth - amplitude;
    ASSERT_GT(left, 0.001);
    const double x = wavelength / 4;
    const auto pushes = springs_of_body(plough, {Vec3(x, 0, 0.001), Vec3(x, 0, -depth)});
    const Vec3 expected = stiffness * left * Vec3(amplitude * s, 0, 1);
    EXPECT_LT((pushes[1] - expected).norm(), 1e-6);
}

SurfaceTexture random_texture(std::mt19937_64& random)
{
    std::uniform_real_distribution<double> unit(0, 1);
    const auto between = [&](double least, double most) {
        return least * std::pow(most / least, unit(random));
    };
    SurfaceTexture texture;
    texture.bump.shape = static_cast<BumpShape>(random() % 5);
    if (texture.bump.shape == BumpShape::image)
        texture.bump.image = testing::random_image(random(), 1 + random() % 40, 1 + random() % 40);
    texture.bump.amplitude = random() % 3 == 0 ? 0.01 : between(1e-6, 0.01);
    texture.bump.wavelength = between(1e-4, 1);
    texture.bump.direction = Vec3(unit(random) - 0.5, unit(random) - 0.5, 1e-3);
    texture.viscosity = random() % 2 == 0 ? 0 : between(1e-3, 1e9);
    if (random() % 2 == 0)
        texture.stick_slip = {.stiffness = between(1, 1e9), .max_force = between(1e-3, 1e9)};
    if (random() % 2 == 0) {
        texture.tap = {
            .gain = between(1e-2, 1e9), .frequency = between(10, 400), .decay = between(10, 1000)};
    }
    return texture;
}

class TextureRecording : public FolderTest {};

TEST_F(TextureRecording, RandomTexturesKeepTheLimitsAndReplayBitForBit)
{
    const std::uint64_t seed = std::random_device()();
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    int forces = 0;
    for (const testing::TouchMesh& touched : testing::touch_meshes()) {
        const TriangleMesh& mesh = touched.mesh;
        SCOPED_TRACE(touched.name);
        const auto index = build_mesh_index(mesh);
        ASSERT_TRUE(index);
        const DeviceLimits& device = known_devices()[random() % known_devices().size()];
        Recording recording;
        RecordingSettings& settings = recording.settings;
        settings.map = fit_workspace(bounding_box(mesh), device.workspace_radius);
        settings.max_force = device.max_force;
        settings.max_stiffness = device.max_stiffness;
        settings.max_damping = device.max_damping;
        RenderOptions options;
        options.force.stiffness = device.max_stiffness;
        options.proxy_radius = random() % 2 == 0 ? 0 : 0.002;
        if (random() % 2 == 0) options.static_friction = options.dynamic_friction = 0;
        options.texture = random_texture(random);
        auto renderer = make_haptic_renderer(*index, settings.map, device, options);
        ASSERT_TRUE(renderer) << describe(renderer.error());
        settings.render = renderer->options();
        testing::HandPath path(mesh, static_cast<std::uint32_t>(random()));
        Vec3 before = settings.map.to_device(path.next());
        Vec3 force = Vec3::Zero();
        for (int tick = 0; tick < 1500; ++tick) {
            const Vec3 at = settings.map.to_device(path.next());
            const DeviceState state = state_at(at, (at - before) / tick_seconds);
            before = at;
            const std::size_t allocations = testing::allocation_count();
            const RenderTick& felt = renderer->tick(state, tick_seconds);
            ASSERT_EQ(testing::allocation_count(), allocations);
            ASSERT_TRUE(felt.force.allFinite());
            ASSERT_LE(felt.force.norm(), device.max_force);
            if (felt.fault == InputFault::none) {
                ASSERT_LE((felt.force - force).norm(),
                          options.force.max_slew * tick_seconds * (1 + 1e-12));
            }
            force = felt.force;
            forces += felt.texture != Vec3::Zero() ? 1 : 0;
            recording.ticks.push_back(recorded(tick * tick_seconds, state, felt));
        }
        const auto file = folder() / "textured.pxt";
        ASSERT_TRUE(save_recording(recording, file));
        const auto loaded = load_recording(file);
        ASSERT_TRUE(loaded) << describe(loaded.error());
        auto again = make_haptic_renderer(*index, settings.map, device, loaded->settings.render);
        ASSERT_TRUE(again);
        EXPECT_EQ(count_differences(*loaded, *again), 0U);
    }
    EXPECT_GT(forces, 100);
}

TEST(SurfaceTexture, NoneAndZeroOnesChangeNoBit)
{
    const TriangleMesh mesh = *sample_mesh("torus:24x12");
    const auto index = build_mesh_index(mesh);
    const WorkspaceMap map = fit_workspace(bounding_box(mesh), 0.1);
    SurfaceTexture zero;
    zero.bump.shape = BumpShape::noise;
    zero.stick_slip.stiffness = 100; // and no force
    RenderOptions plain;
    auto without = make_haptic_renderer(*index, map, omni, plain);
    auto with = make_haptic_renderer(*index, map, omni, with_texture(zero, plain));
    // An object of a scene without a texture, in a renderer that has one for others.
    const auto smooth = build_touch_body(*index, {.texture = SurfaceTexture{}});
    TouchScene scene(Box{Vec3(-9, -9, -9), Vec3(9, 9, 9)});
    TouchScene plain_scene(Box{Vec3(-9, -9, -9), Vec3(9, 9, 9)});
    ASSERT_TRUE(scene.add(*smooth, {}));
    ASSERT_TRUE(plain_scene.add(*build_touch_body(*index), {}));
    auto in_scene = make_haptic_renderer(scene, map, omni,
                                         with_texture({.viscosity = 3, .tap = {.gain = 3}}, plain));
    auto in_plain_scene = make_haptic_renderer(plain_scene, map, omni, plain);
    testing::HandPath path(mesh, 3);
    int touching = 0;
    for (int tick = 0; tick < 3000; ++tick) {
        const DeviceState state = state_at(map.to_device(path.next()), Vec3(0.01, 0.02, 0.03));
        const auto a = recorded(0, state, without->tick(state, tick_seconds));
        const auto b = recorded(0, state, with->tick(state, tick_seconds));
        ASSERT_TRUE(same_response(a, b)) << tick;
        const auto c = recorded(0, state, in_scene->tick(state, tick_seconds));
        const auto d = recorded(0, state, in_plain_scene->tick(state, tick_seconds));
        ASSERT_TRUE(same_response(c, d)) << tick;
        touching += without->last().hold != Hold::free ? 1 : 0;
    }
    EXPECT_GT(touching, 500);
}

TEST(SurfaceTexture, TurnsAndMovesWithItsObject)
{
    for (const BumpShape shape : {BumpShape::noise, BumpShape::image}) {
        SurfaceTexture texture = bumpy(shape);
        texture.bump.direction = Vec3(0.2, 0.3, 1);
        const auto body = build_touch_body(cube_mesh(Vec3::Zero(), 0.5), {.texture = texture});
        ASSERT_TRUE(body);
        const RigidTransform pose = {
            Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix(),
            Vec3(1, -2, 0.5)};
        TouchScene there(Box{Vec3(-9, -9, -9), Vec3(9, 9, 9)});
        TouchScene here(Box{Vec3(-9, -9, -9), Vec3(9, 9, 9)});
        ASSERT_TRUE(there.add(*body, pose));
        ASSERT_TRUE(here.add(*body, {}));
        const RenderOptions options = spring_alone(stiffness);
        auto turned = make_haptic_renderer(there, {1, Vec3::Zero()}, omni, options);
        auto plain = make_haptic_renderer(here, {1, Vec3::Zero()}, omni, options);
        double most = 0;
        for (int tick = 0; tick < 300; ++tick) {
            const Vec3 p(1e-4 * tick, 5e-5 * tick, 0.501 - 1e-5 * tick);
            const RenderTick& a = plain->tick(state_at(p), tick_seconds);
            const RenderTick& b = turned->tick(state_at(pose(p)), tick_seconds);
            EXPECT_LT((pose.rotation * a.force - b.force).norm(), 1e-5) << tick;
            most = std::max(most, a.texture.norm());
        }
        EXPECT_GT(most, 0.03) << static_cast<int>(shape);
    }
}

TEST(SurfaceTexture, NumbersOutOfRangeAreNamed)
{
    const auto index = build_mesh_index(*sample_mesh("cube"));
    const auto message = [&](const SurfaceTexture& texture) {
        RenderOptions options;
        options.texture = texture;
        const auto made = make_haptic_renderer(*index, {1, Vec3::Zero()}, omni, options);
        const auto body = build_touch_body(*index, {.texture = texture});
        EXPECT_EQ(made.has_value(), body.has_value());
        if (made) return std::string();
        EXPECT_EQ(made.error().message, body.error().message);
        return made.error().message;
    };
    EXPECT_EQ(message({}), "");
    EXPECT_EQ(message({.bump = {.amplitude = 0.02}}),
              "the bump amplitude of a texture is 0.02 and must be 0 to 0.01");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const auto& [name, texture] : std::vector<std::pair<std::string, SurfaceTexture>>{
             {"bump wavelength", {.bump = {.wavelength = 0}}},
             {"bump wavelength", {.bump = {.wavelength = nan}}},
             {"bump direction", {.bump = {.direction = Vec3::Zero()}}},
             {"bump direction", {.bump = {.direction = Vec3(nan, 0, 0)}}},
             {"viscosity", {.viscosity = -1}},
             {"stick-slip stiffness", {.stick_slip = {.stiffness = 2e9}}},
             {"stick-slip max_force", {.stick_slip = {.max_force = nan}}},
             {"tap gain", {.tap = {.gain = -1}}},
             {"tap frequency", {.tap = {.frequency = 0}}},
             {"tap decay", {.tap = {.decay = 1e4}}}}) {
        EXPECT_NE(message(texture).find(name), std::string::npos) << name;
    }
}

} // namespace
} // namespace proxima::surface_texture_test
