// Taps of textures against a decaying sine, and what energy they give.
#include "haptics/force/surface_renderer.h"
#include "haptics/force/surface_texture.h"
#include "haptics/spring_alone.h"
#include "haptics/textured_table.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace proxima::texture_taps_test {
namespace {

using namespace testing;

constexpr Tap test_tap = {.gain = 1, .frequency = 150, .decay = 80};

/// Steps into the table at a speed, and on for some ticks. Calls visit(ticks since the impact, tick).
template <class Visit>
void tap_at(Table& table, double speed, int ticks, Visit&& visit)
{
    double z = 0.01 - 1e-7;
    table.rest(Vec3(0, 0, z));
    int since = -1;
    for (int tick = 0; since < ticks; ++tick) {
        z -= speed * tick_seconds;
        const RenderTick& felt = table.go(Vec3(0, 0, z));
        if (since >= 0 || z < 0) visit(++since, felt);
    }
}

TEST(SurfaceTexture, TapIsADecayingSine)
{
    RenderOptions options = spring_alone(stiffness);
    options.texture.tap = test_tap;
    for (const double speed : {0.05, 0.1}) {
        Table table(options);
        double greatest = 0;
        tap_at(table, speed, 30, [&](int since, const RenderTick& felt) {
            const double t = tick_seconds * since;
            const double expected =
                speed * std::exp(-80 * t) * std::sin(2 * std::numbers::pi * 150 * t);
            EXPECT_NEAR(felt.tap, expected, 1e-7) << since;
            EXPECT_NEAR(felt.force.z(), felt.spring.z() + expected, 1e-7) << since;
            greatest = std::max(greatest, felt.tap);
        });
        EXPECT_GT(greatest, 0.6 * speed);
        EXPECT_EQ(table.report().taps, 1U);
        tap_at(table, speed, 60, [&](int since, const RenderTick& felt) {
            if (since > 50) {
                EXPECT_EQ(felt.tap, 0) << since;
            }
        });
    }
}

TEST(SurfaceTexture, TapHasAGreatestForce)
{
    RenderOptions options = spring_alone(stiffness);
    options.texture.tap = {.gain = 20, .frequency = 150, .decay = 80};
    Table table(options);
    tap_at(table, 0.9, 3,
           [&](int, const RenderTick& felt) { EXPECT_LE(std::abs(felt.tap), omni.max_force / 2); });
    EXPECT_EQ(table.report().taps, 1U);
}

TEST(SurfaceTexture, NoTapWithoutAnImpactInARampOrOnASoftenedWall)
{
    const auto taps = [](Table& table, double speed) {
        tap_at(table, speed, 20, [](int, const RenderTick&) {});
        return table.report().taps;
    };
    RenderOptions options = spring_alone(stiffness);
    Table off(options);
    EXPECT_EQ(taps(off, 0.1), 0U);
    options.texture.tap = test_tap;
    Table slow(options);
    EXPECT_EQ(taps(slow, 0.005), 0U);
    Table on(options);
    EXPECT_EQ(taps(on, 0.1), 1U);
    // Fluttering at the surface.
    for (int tick = 0; tick < 100; ++tick) on.go(Vec3(0, 0, tick % 10 < 5 ? 1e-4 : -4e-4));
    EXPECT_EQ(on.report().taps, 1U);
    options.force.start_seconds = 1;
    Table ramping(options);
    tap_at(ramping, 0.1, 20, [](int, const RenderTick& felt) { EXPECT_EQ(felt.tap, 0); });
    options.force.start_seconds = 0;
    // A guard that has softened: a wall of 5000 N/m that a free mass swings in.
    DeviceLimits delta = *find_device("delta");
    options.force.stiffness = delta.max_stiffness;
    options.guard = Guard::on;
    Table swinging(options, delta);
    swinging.rest(Vec3(0, 0, 0.001));
    for (int tick = 0; tick < 1500; ++tick) {
        const double z = -0.003 + 0.002 * std::exp(0.002 * tick) * std::sin(0.2 * tick);
        swinging.go(Vec3(0, 0, std::min(z, -1e-4)));
    }
    ASSERT_LT(parts_of(swinging.renderer()).passivity().softness(), 1);
    const std::uint64_t before = swinging.report().taps;
    for (int tick = 0; tick < 40; ++tick) swinging.go(Vec3(0, 0, 0.003 - 1e-4 * tick));
    EXPECT_EQ(swinging.report().taps, before);
}

TEST(SurfaceTexture, TapGivesNoMoreThanDeclaredToAHandThatMovesWithIt)
{
    RenderOptions options = spring_alone(stiffness);
    options.texture.tap = {.gain = 5, .frequency = 100, .decay = 10};
    for (const double hand_speed : {0.02, 0.1, 0.5}) {
        Table table(options);
        table.rest(Vec3(0, 0, 0.005 - 1e-7));
        double z = 0.005;
        double given = 0;
        double tap = 0;
        bool deep = false; // from then on the hand moves as the tap pushes
        for (int tick = 0; tick < 400; ++tick) {
            const double before = z;
            z += tick_seconds * (deep ? std::copysign(hand_speed, tap) : -0.1);
            if (deep) z = std::clamp(z, -0.02, -0.001);
            given += tap * (z - before);
            tap = table.go(Vec3(0, 0, z)).tap;
            deep = deep || z < -0.0015;
        }
        ASSERT_EQ(table.report().taps, 1U);
        const double declared = 5 * 0.1 * 0.1 / (std::numbers::pi * 100);
        // The next step of a hand that turns at once is not known: a tick of the greatest force more.
        const double bound = declared + 5 * 0.1 * hand_speed * tick_seconds;
        EXPECT_LE(given, bound) << hand_speed;
        EXPECT_LE(table.report().given, bound) << hand_speed;
        EXPECT_GT(given, 0.1 * declared) << hand_speed;
        RecordProperty("given_over_declared_" + std::to_string(hand_speed),
                       std::to_string(given / declared));
    }
}

} // namespace
} // namespace proxima::texture_taps_test
