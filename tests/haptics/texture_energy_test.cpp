// Textures make no energy on closed paths, and no swings.
#include "haptics/force/surface_renderer.h"
#include "haptics/force/surface_texture.h"
#include "haptics/spring_alone.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/textured_table.h"
#include "lab/simulated_hand.h"
#include "octree/small_meshes.h"
#include "proxima/sample_meshes.h"
#include "proxima/touch_scene.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

namespace proxima::texture_energy_test {
namespace {

using namespace testing;

/// A closed path over a mesh, tick by tick.
struct PathSum {
    double made = 0;   ///< J, by the trapezoidal sum
    double length = 0; ///< m
    double greatest = 0;
    std::uint64_t damped = 0;
};

PathSum go_round(const RenderOptions& options, const TriangleMesh& mesh, const Vec3& middle,
                 const std::function<Vec3(double)>& path, int ticks,
                 const DeviceLimits& device = omni)
{
    const MeshContactSurface surface(mesh);
    HapticRenderer renderer = make_surface_renderer(surface, {1, Vec3::Zero()}, device, options);
    Vec3 before = middle + path(0);
    Vec3 outside = before.normalized() * 1.5;
    for (int tick = 0; tick <= 2000; ++tick)
        renderer.tick(state_at(outside + tick / 2000.0 * (before - outside)), tick_seconds);
    PathSum sum;
    Vec3 force = renderer.last().force;
    for (int tick = 1; tick <= ticks; ++tick) {
        const Vec3 at = middle + path(static_cast<double>(tick) / ticks);
        const RenderTick& felt =
            renderer.tick(state_at(at, (at - before) / tick_seconds), tick_seconds);
        sum.made += 0.5 * (felt.force + force).dot(at - before);
        sum.length += (at - before).norm();
        sum.greatest = std::max(sum.greatest, felt.force.norm());
        force = felt.force;
        before = at;
    }
    sum.damped = parts_of(renderer).texture().report().damped_ticks;
    return sum;
}

TEST(SurfaceTexture, ClosedPathsOnAPlaneMakeNoEnergy)
{
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 0.5);
    const auto loop = [](double part) {
        const double angle = 2 * std::numbers::pi * part;
        return Vec3(0.01 * std::cos(angle), 0.008 * std::sin(2 * angle),
                    -0.0012 + 0.0011 * std::sin(3 * angle));
    };
    for (const BumpShape shape :
         {BumpShape::grating, BumpShape::dimples, BumpShape::noise, BumpShape::image}) {
        RenderOptions options = spring_alone(stiffness);
        options.texture = bumpy(shape);
        const Vec3 middle(0.1, 0.05, 0.5);
        const PathSum coarse = go_round(options, cube, middle, loop, 8000);
        const PathSum fine = go_round(options, cube, middle, loop, 32000);
        // The trapezoidal sum is exact to the square of the step: to a millionth of the work done.
        const double work = coarse.greatest * coarse.length;
        EXPECT_LT(std::abs(coarse.made), 1e-5 * work) << static_cast<int>(shape);
        EXPECT_LT(std::abs(fine.made), 1e-6 * work) << static_cast<int>(shape);
        RecordProperty("made_of_work_" + std::to_string(static_cast<int>(shape)),
                       std::to_string(1e6 * fine.made / work) + "e-6");
    }
}

TEST(SurfaceTexture, PathsOverEdgesMakeNoEnergyBeyondThoseWithoutATexture)
{
    // Between its outer edges a proxy drops, which takes energy, with grooves as without.
    const TriangleMesh ball = *sample_mesh("icosphere:2");
    const auto loop = [](double part) {
        const double angle = 2 * std::numbers::pi * part;
        return Vec3(0.98 * std::cos(angle), 0.98 * std::sin(angle), 0.1 * std::sin(3 * angle));
    };
    for (const BumpShape shape :
         {BumpShape::none, BumpShape::grating, BumpShape::noise, BumpShape::image}) {
        RenderOptions options = spring_alone(stiffness);
        options.texture = bumpy(shape);
        DeviceLimits strong = omni;
        strong.max_force = 100;
        options.texture.bump.wavelength = shape == BumpShape::image ? 0.08 : 0.02;
        options.texture.bump.amplitude = 2e-4;
        const PathSum sum = go_round(options, ball, Vec3::Zero(), loop, 60000, strong);
        EXPECT_LT(sum.made, 1e-6 * sum.greatest * sum.length) << static_cast<int>(shape);
        EXPECT_GT(sum.greatest, 5) << static_cast<int>(shape);
    }
}

/// Rounds about the border of a plain and a textured block, onto the texture on a crest and off it in
/// a groove: each would give K e 2 A. Returns what all gave, J.
double made_about_a_border(Guard guard, double amplitude, int rounds, TextureReport& report)
{
    const double wavelength = 0.02;
    TouchScene scene(Box{Vec3(-2, -2, -2), Vec3(2, 2, 2)});
    const SurfaceTexture waves = {.bump = {.shape = BumpShape::grating,
                                           .amplitude = amplitude,
                                           .wavelength = wavelength,
                                           .direction = Vec3::UnitY()}};
    const TriangleMesh block = cube_mesh(Vec3::Zero(), 0.5);
    EXPECT_TRUE(scene.add(*build_touch_body(block), {Mat3::Identity(), Vec3(-0.5, 0, -0.5)}));
    EXPECT_TRUE(scene.add(*build_touch_body(block, {.texture = waves}),
                          {Mat3::Identity(), Vec3(0.5, 0, -0.5)}));
    RenderOptions options = spring_alone(stiffness);
    options.guard = guard;
    auto renderer = make_haptic_renderer(scene, {1, Vec3::Zero()}, omni, options);
    EXPECT_TRUE(renderer);
    const std::array<Vec3, 5> corners = {
        Vec3(-0.01, 0, -0.002), Vec3(0.01, 0, -0.002), Vec3(0.01, wavelength / 2, -0.002),
        Vec3(-0.01, wavelength / 2, -0.002), Vec3(-0.01, 0, -0.002)};
    Vec3 before(-0.01, 0, 0.002);
    for (int tick = 0; tick <= 40; ++tick) {
        before.z() = 0.002 - 1e-4 * tick;
        renderer->tick(state_at(before), tick_seconds);
    }
    double made = 0;
    Vec3 force = renderer->last().force;
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t side = 0; side < 4; ++side) {
            for (int step = 1; step <= 200; ++step) {
                const Vec3 at = corners[side] + step / 200.0 * (corners[side + 1] - corners[side]);
                const RenderTick& felt =
                    renderer->tick(state_at(at, (at - before) / tick_seconds), tick_seconds);
                made += 0.5 * (felt.force + force).dot(at - before);
                force = felt.force;
                before = at;
            }
        }
    }
    report = parts_of(*renderer).texture().report();
    return made;
}

TEST(SurfaceTexture, ObserverTakesBackWhatABorderOfTexturesGives)
{
    constexpr double amplitude = 1e-4;
    constexpr int rounds = 20;
    TextureReport report;
    const double each = stiffness * 0.002 * 2 * amplitude;
    EXPECT_NEAR(made_about_a_border(Guard::off, amplitude, rounds, report), rounds * each,
                0.1 * rounds * each);
    EXPECT_EQ(report.damped_ticks, 0U);
    // At most what is given once, and is not taken back yet.
    EXPECT_LT(made_about_a_border(Guard::on, amplitude, rounds, report), each);
    EXPECT_GT(report.damped_ticks, 100U);
}

/// A hand that presses on the table and holds still, with no damping but the device's.
struct HeldHand {
    DeviceLimits device;
    SurfaceTexture texture;
    int delay = 0;
    Vec3 target = Vec3::Zero(); ///< m
    Guard guard = Guard::on;
};

/// The most that the device moves to and fro along any axis in half a second of the last four, m.
double swing_of(const HeldHand& held)
{
    RenderOptions options;
    options.force.stiffness = held.device.max_stiffness;
    options.force.damping = 0;
    options.static_friction = options.dynamic_friction = 0;
    options.guard = held.guard;
    options.texture = held.texture;
    Table table(options, held.device);
    table.rest(Vec3(0, 0, 0.001));
    HandModel model;
    model.device_damping = 0.1;
    model.hand_damping = 0;
    model.delay_ticks = held.delay;
    SimulatedHand hand(model, Vec3(0, 0, 0.001));
    Box box;
    double most = 0;
    for (int tick = 0; tick < 10000; ++tick) {
        const RenderTick& felt = table.renderer().tick(hand.state(), tick_seconds);
        EXPECT_LE(felt.force.norm(), held.device.max_force);
        hand.step(felt.force, held.target);
        if (!(hand.position().norm() < 0.5)) return 1;
        if (tick < 6000) continue;
        if (tick % 500 == 0) box = {};
        box.extend(hand.position());
        most = std::max(most, box.extent().maxCoeff() / 2);
    }
    return most;
}

TEST(SurfaceTexture, HardestSettingsOfEveryDeviceEndBelowAMillimetre)
{
    const std::vector<std::pair<std::string, SurfaceTexture>> textures = {
        {"grating",
         {.bump = {.shape = BumpShape::grating, .amplitude = 0.01, .wavelength = 0.003}}},
        {"dimples", {.bump = {.shape = BumpShape::dimples, .amplitude = 0.01, .wavelength = 0.02}}},
        {"noise", {.bump = {.shape = BumpShape::noise, .amplitude = 0.01, .wavelength = 0.001}}},
        {"image",
         {.bump = {.shape = BumpShape::image,
                   .amplitude = 0.01,
                   .wavelength = 0.02,
                   .direction = Vec3::UnitZ(),
                   .image = testing::random_image(12, 12, 12)}}},
        {"viscosity", {.viscosity = 1e9}},
        {"stick-slip", {.stick_slip = {.stiffness = 1e9, .max_force = 1e9}}},
        {"short stick-slip", {.stick_slip = {.stiffness = 1e9, .max_force = 0.2}}},
        {"tap", {.tap = {.gain = 1e9}}},
        {"all",
         {.bump = {.shape = BumpShape::noise, .amplitude = 0.01, .wavelength = 0.004},
          .viscosity = 1,
          .stick_slip = {.stiffness = 300, .max_force = 0.5},
          .tap = {.gain = 2}}}};
    int diverging = 0;
    for (const DeviceLimits& device : known_devices()) {
        for (const auto& [name, texture] : textures) {
            for (const int delay : {0, 1, 2, 3}) {
                for (const Vec3& target : {Vec3(0.004, 0.002, -0.006), Vec3(0.004, 0, 0)}) {
                    HeldHand held = {
                        .device = device, .texture = texture, .delay = delay, .target = target};
                    EXPECT_LT(swing_of(held), 1e-3) << device.name << ' ' << name << " delay "
                                                    << delay << " at " << target.transpose();
                    held.guard = Guard::off;
                    if (delay == 3 && name == "grating") diverging += swing_of(held) > 5e-3 ? 1 : 0;
                }
            }
        }
    }
    EXPECT_GT(diverging, 6); // without the guard
}

} // namespace
} // namespace proxima::texture_energy_test
