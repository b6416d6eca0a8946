// What the passivity guard does to walls that are too stiff for a device, through the whole
// renderer, and that it leaves the others alone.
#include "haptics/wall_swing.h"

#include "haptics/force/oscillation_detector.h"
#include "proxima/device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace proxima {
namespace {

using testing::swing;
using testing::SwingResult;
using testing::SwingSetting;
using testing::SwingWall;
using testing::WallSides;

/// How a hand stands before a wall.
struct Stand {
    WallSides sides;
    double hand_stiffness;
    double target; ///< m
};

constexpr std::array<Stand, 3> stands = {{{WallSides::two, 0, 0},
                                          {WallSides::one, 150, 0},        // grazes it
                                          {WallSides::one, 150, -0.005}}}; // presses

std::string describe(const SwingSetting& setting, const Stand& stand)
{
    return std::string(setting.device.name) + " K " + std::to_string(setting.stiffness) + " B " +
           std::to_string(setting.damping) + " b " + std::to_string(setting.hand.device_damping) +
           " delay " + std::to_string(setting.hand.delay_ticks) + " stand " +
           std::to_string(static_cast<int>(stand.sides)) + ' ' + std::to_string(stand.target);
}

/// Calls visit(setting, stand) for every device, with its greatest stiffness and 40 % of it.
template <class Visit>
void for_each_setting(Visit&& visit)
{
    for (const DeviceLimits& device : known_devices()) {
        for (const double share : {1.0, 0.4}) {
            for (const double damping : {0.0, device.max_damping}) {
                for (const double b : {0.1, 0.5}) {
                    for (int delay = 0; delay <= 3; ++delay) {
                        for (const Stand& stand : stands) {
                            SwingSetting setting;
                            setting.device = device;
                            setting.stiffness = share * device.max_stiffness;
                            setting.damping = damping;
                            setting.hand.device_damping = b;
                            setting.hand.hand_damping = 0;
                            setting.hand.hand_stiffness = stand.hand_stiffness;
                            setting.hand.delay_ticks = delay;
                            setting.target = stand.target;
                            visit(setting, stand);
                        }
                    }
                }
            }
        }
    }
}

const SwingWall& wall_of(const Stand& stand)
{
    static const SwingWall one(WallSides::one);
    static const SwingWall two(WallSides::two);
    return stand.sides == WallSides::one ? one : two;
}

TEST(WallSwing, HardestSettingsOfEveryDeviceEndBelowAMillimetre)
{
    int diverging = 0;
    for_each_setting([&](SwingSetting setting, const Stand& stand) {
        const bool hardest = setting.stiffness == setting.device.max_stiffness &&
                             setting.hand.device_damping < 0.5 && setting.hand.delay_ticks != 2;
        if (!hardest) return;
        const SwingResult guarded = swing(wall_of(stand), setting, 12, 2);
        EXPECT_LT(guarded.amplitude, 1e-3) << describe(setting, stand);
        setting.passivity = Passivity::unguarded;
        diverging += swing(wall_of(stand), setting, 4, 1).amplitude > 5e-3 ? 1 : 0;
    });
    EXPECT_GT(diverging, 40);
}

TEST(WallSwing, ForcesBeyondTheLimitOfTheDeviceSustainNoSwing)
{
    // A part of a force far above the device's greatest may still be all that it can give: a swing
    // went on at 80 mm.
    SwingSetting setting;
    setting.device = *find_device("delta");
    setting.hand.device_damping = 0.1;
    setting.hand.hand_damping = 0;
    setting.hand.hand_stiffness = 0;
    for (setting.hand.delay_ticks = 0; setting.hand.delay_ticks <= 3; ++setting.hand.delay_ticks) {
        for (const double share : {0.6, 0.8, 0.9, 1.0}) {
            setting.stiffness = share * setting.device.max_stiffness;
            const SwingResult outcome = swing(wall_of(stands[0]), setting, 4, 2);
            EXPECT_LT(outcome.greatest, 0.01) << describe(setting, stands[0]);
            EXPECT_LT(outcome.amplitude, 1e-4) << describe(setting, stands[0]);
        }
    }
}

TEST(WallSwing, GuardChangesNoBitOfStableSettings)
{
    int stable = 0;
    int same = 0;
    for_each_setting([&](SwingSetting setting, const Stand& stand) {
        const HandModel& hand = setting.hand;
        const double late = hand.tick_seconds * (0.5 + hand.delay_ticks);
        // By a third below the limit, and with damping that does not swing by itself.
        const double whole = setting.stiffness + hand.hand_stiffness;
        if (whole * late > 2.0 / 3 * (hand.device_damping + setting.damping) ||
            setting.damping * (late + 0.5 * hand.tick_seconds) > 0.5 * hand.mass)
            return;
        ++stable;
        const SwingResult guarded = swing(wall_of(stand), setting, 4, 1);
        EXPECT_EQ(guarded.softened, 0U) << describe(setting, stand);
        if (guarded.damped != 0) return; // the observer's damping, as ever
        setting.passivity = Passivity::unguarded;
        EXPECT_EQ(swing(wall_of(stand), setting, 4, 1).checksum, guarded.checksum);
        ++same;
    });
    EXPECT_GT(stable, 30);
    EXPECT_GT(same, 10);
    RecordProperty("stable_settings", stable);
    RecordProperty("same_bits", same);
}

TEST(WallSwing, CoarseEncodersEndBelowThreeMillimetres)
{
    for (const double b : {0.1, 0.5}) {
        for (int delay = 0; delay <= 3; ++delay) {
            SwingSetting setting;
            setting.stiffness = 700;
            setting.target = -0.01;
            setting.hand.device_damping = b;
            setting.hand.hand_damping = 0;
            setting.hand.delay_ticks = delay;
            setting.hand.encoder_step = 5e-5;
            EXPECT_LT(swing(wall_of(stands[1]), setting, 15, 2).amplitude, 3e-3) << b << delay;
        }
    }
}

TEST(OscillationDetector, IgnoresTappingAndPressingHands)
{
    // Presses of 3 mm that come back as fast as they went, and taps from above.
    for (const double per_second : {0.5, 2.0, 4.0}) {
        OscillationDetector watch;
        for (int tick = 0; tick < 20000; ++tick) {
            const double phase = 2 * 3.14159265358979 * per_second * 1e-3 * tick;
            const double above = 0.003 * std::cos(phase) - 0.001;
            const double depth = std::max(-above, 0.0);
            EXPECT_EQ(watch.watch(Vec3(0, 0, above), Vec3(0, 0, 500 * depth), 1e-3), 0) << tick;
        }
    }
}

TEST(OscillationDetector, IgnoresAQuickRelease)
{
    // A hand rests on the wall for a fifth of a second, trembling, and is drawn back fast.
    for (const double tremor : {1e-4, 2e-4, 3e-4}) {
        for (const double per_second : {8.0, 10.0, 12.0}) {
            for (const double acceleration : {3.0, 10.0, 30.0}) {
                OscillationDetector watch;
                for (int tick = 0; tick < 400; ++tick) {
                    const double t = 1e-3 * tick;
                    const double left = std::max(t - 0.2, 0.0);
                    const double above = tremor * std::sin(2 * 3.14159265358979 * per_second * t) -
                                         0.002 + 0.5 * acceleration * left * left;
                    const double depth = std::max(-above, 0.0);
                    ASSERT_EQ(watch.watch(Vec3(0, 0, above), Vec3(0, 0, 500 * depth), 1e-3), 0)
                        << tremor << ' ' << per_second << ' ' << acceleration << ' ' << tick;
                }
            }
        }
    }
}

/// The tick in which a swing of 0.5 mm is seen that grows by so much a turn, up to e^2; -1 for
/// never.
int seen_swing(double per_second, double growth, double encoder_step)
{
    OscillationDetector watch;
    for (int tick = 0; tick < 2000; ++tick) {
        const double t = 1e-3 * tick;
        const double size = 5e-4 * std::exp(std::clamp(2 * per_second * growth * t, -9.0, 2.0));
        double x = size * std::sin(2 * 3.14159265358979 * per_second * t + 0.3);
        if (encoder_step > 0) x = std::round(x / encoder_step) * encoder_step;
        if (watch.watch(Vec3(x, 0, 0), Vec3(-500 * x, 0, 0), 1e-3) > 0) return tick;
    }
    return -1;
}

TEST(OscillationDetector, DetectsGrowingSwingsWithinTwentyTurnsAtAnyRate)
{
    // Up to nearly half the rate of the ticks.
    for (double per_second = 10; per_second < 480; per_second *= 1.03) {
        for (const double encoder_step : {0.0, 5e-5}) {
            const int seen = seen_swing(per_second, 0.1, encoder_step);
            EXPECT_GE(seen, 0) << per_second << ' ' << encoder_step;
            // In turns; where speeds are means of many ticks of a turn, some more go by.
            EXPECT_LT(seen * 2e-3 * per_second, 20) << per_second << ' ' << encoder_step;
        }
    }
}

TEST(OscillationDetector, IgnoresFadingSwingsAtAnyRate)
{
    // Nearer to half the rate of the ticks, what is seen of a swing beats, and rises now and then.
    for (double per_second = 10; per_second < 400; per_second *= 1.03) {
        for (const double encoder_step : {0.0, 5e-5})
            EXPECT_EQ(seen_swing(per_second, -0.1, encoder_step), -1) << per_second;
    }
}

} // namespace
} // namespace proxima
