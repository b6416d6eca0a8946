// What the passivity guard does to walls that are too stiff for a device, through the whole
// renderer, and that it leaves the others alone.
#include "haptics/theory_wall.h"
#include "haptics/wall_swing.h"

#include "haptics/force/energy_account.h"
#include "haptics/force/swing_bounces.h"
#include "haptics/force/swing_detector.h"
#include "proxima/device.h"
#include "proxima/sample_meshes.h"
#include "proxima/touch_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

namespace proxima::wall_swing_test {
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
           " mass " + std::to_string(setting.hand.mass) + " delay " +
           std::to_string(setting.hand.delay_ticks) + " stand " +
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
        const bool hardest =
            setting.stiffness == setting.device.max_stiffness && setting.hand.device_damping < 0.5;
        if (!hardest) return;
        // Where a heavier mass saturates the force, the slew limit makes it later than the device does.
        for (const double mass : {0.35, 0.1}) {
            setting.hand.mass = mass;
            const SwingResult guarded = swing(wall_of(stand), setting, 12, 2);
            EXPECT_LT(guarded.amplitude, 1e-3) << describe(setting, stand);
        }
        setting.guard = Guard::off;
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
        setting.guard = Guard::off;
        EXPECT_EQ(swing(wall_of(stand), setting, 4, 1).checksum, guarded.checksum);
        ++same;
    });
    EXPECT_GT(stable, 30);
    EXPECT_GT(same, 10);
    RecordProperty("stable_settings", stable);
    RecordProperty("same_bits", same);
}

/// The highest places, m, of a mass that an even push moves to a wall.
struct Heights {
    double first = -1; ///< in the first two seconds
    double ever = -1;
    double last = -1; ///< in the last two of twenty
};

RenderOptions stiffest(const DeviceLimits& device, Guard guard)
{
    RenderOptions options;
    options.force.stiffness = device.max_stiffness;
    options.force.damping = 0;
    options.guard = guard;
    return options;
}

/// Above a wall at z = 0, which goes down with that velocity from the 300th tick on.
Heights bounce_under_a_push(HapticRenderer& renderer, double mass, double push, double start,
                            double down = 0)
{
    HandModel model = testing::without_hand();
    model.mass = mass;
    model.device_damping = 0.1;
    model.delay_ticks = 3;
    DeviceState rest;
    rest.pose.translation = Vec3(0, 0, 1e-3);
    for (int tick = 0; tick < 300; ++tick) renderer.tick(rest, model.tick_seconds);
    SimulatedHand hand(model, Vec3(0, 0, start));
    Heights highest;
    for (int tick = 0; tick < 20000; ++tick) {
        const Vec3 force = renderer.tick(hand.state(), model.tick_seconds).force;
        hand.step(force - Vec3(0, 0, push), Vec3::Zero());
        const double height = hand.position().z() + down * tick * model.tick_seconds;
        highest.ever = std::max(highest.ever, height);
        if (tick < 2000) highest.first = std::max(highest.first, height);
        if (tick >= 18000) highest.last = std::max(highest.last, height);
    }
    return highest;
}

Heights bounce_under_a_push(const DeviceLimits& device, double mass, double push, double start,
                            Guard guard)
{
    HapticRenderer renderer = make_surface_renderer(wall_of(stands[1]).surface(), SwingWall::map(),
                                                    device, stiffest(device, guard));
    return bounce_under_a_push(renderer, mass, push, start);
}

TEST(WallSwing, BouncesUnderAnEvenPushEnd)
{
    // Flights of up to two seconds: half the weight of 100 g in place of a spring that holds the device.
    int higher = 0;
    std::printf("highest bounce, mm: with the guard, and after 18 s; without it, and after 18 s\n");
    for (const DeviceLimits& device : known_devices()) {
        Heights with;
        Heights without;
        for (const double mass : {0.1, 0.35}) {
            for (const double start : {-1e-3, 0.01}) {
                for (const double push : {0.2, 0.5}) {
                    const Heights guarded =
                        bounce_under_a_push(device, mass, push, start, Guard::on);
                    // From above, 0.35 kg on an omni take longer.
                    EXPECT_LT(guarded.last, start < 0 ? 1e-3 : 0.01)
                        << device.name << ' ' << mass << ' ' << start << ' ' << push;
                    const Heights alone =
                        bounce_under_a_push(device, mass, push, start, Guard::off);
                    higher += alone.last > 2 * alone.first ? 1 : 0;
                    with.ever = std::max(with.ever, guarded.ever);
                    with.last = std::max(with.last, guarded.last);
                    without.ever = std::max(without.ever, alone.ever);
                    without.last = std::max(without.last, alone.last);
                }
            }
        }
        std::printf("%-8s %5.0f %5.2f  %5.0f %5.0f\n", std::string(device.name).c_str(),
                    1e3 * with.ever, 1e3 * with.last, 1e3 * without.ever, 1e3 * without.last);
    }
    EXPECT_GT(higher, 10);
}

/// As bounce_under_a_push(), above a wall that is an object of a scene.
Heights bounce_on_a_wall_that_moves(const DeviceLimits& device, double mass, double push,
                                    double start, double down, Guard guard)
{
    TouchScene scene({Vec3(-5, -5, -5), Vec3(5, 5, 5)});
    const TouchBody body =
        build_touch_body(*sample_mesh("cube"),
                         {.material = SurfaceMaterial{.stiffness = device.max_stiffness}})
            .value();
    const RigidTransform place{Mat3::Identity(), Vec3(0, 0, -1)};
    const ObjectId object = scene.add(body, place).value();
    HapticRenderer renderer =
        make_haptic_renderer(scene, WorkspaceMap{}, device, stiffest(device, guard)).value();
    EXPECT_TRUE(scene.move(
        object,
        {.pose = place, .seconds = 0.3, .velocity = Vec3(0, 0, -down), .coast_seconds = 21}));
    return bounce_under_a_push(renderer, mass, push, start, down);
}

TEST(WallSwing, BouncesOnAWallThatMovesEnd)
{
    // Towards the device, and away from it, where a bounce that gives energy may leave none in space.
    for (const char* const name : {"touch", "omni", "desktop", "omega"}) {
        const DeviceLimits device = *find_device(name);
        for (const double down : {1e-3, 0.1, -0.05}) {
            for (const double start : {0.01, 0.05}) {
                for (const double mass : {0.1, 0.35}) {
                    const auto last = [&](Guard guard) {
                        return bounce_on_a_wall_that_moves(device, mass, 0.5, start, down, guard)
                            .last;
                    };
                    EXPECT_LT(last(Guard::on), 0.015)
                        << name << ' ' << down << ' ' << start << ' ' << mass;
                    EXPECT_GT(last(Guard::off), 0.03)
                        << name << ' ' << down << ' ' << start << ' ' << mass;
                }
            }
        }
    }
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

/// Ratio of a mass's speeds after and before a bounce off a wall with damping, and the time in
/// contact, s. The force is never negative and acts after some ticks.
std::array<double, 2> bounce(const HandModel& model, double stiffness, double damping, double phase)
{
    constexpr double speed = 0.1;
    const double tick = model.tick_seconds;
    SimulatedHand hand(model, Vec3(0, 0, phase * speed * tick));
    hand.set_motion(Vec3(0, 0, phase * speed * tick), Vec3(0, 0, -speed));
    double contact = 0;
    int apart = 0; // ticks since the last contact
    while (contact == 0 || apart <= model.delay_ticks + 1) {
        const DeviceState state = hand.state();
        const double z = state.pose.translation.z();
        // Far below: no wall holds it.
        if (z < -1) return {0, contact};
        const double force = std::max(-stiffness * z - damping * state.velocity.z(), 0.0);
        apart = z < 0 ? 0 : apart + 1;
        contact += z < 0 ? tick : 0;
        hand.step(Vec3(0, 0, z < 0 ? force : 0.0), Vec3::Zero());
    }
    return {hand.velocity().z() / speed, contact};
}

TEST(WallSwing, FullyDampedWallsGiveEnergyInBriefContactsAlone)
{
    // What the guard softens by: six delays of the damping of four ticks each.
    constexpr int phases = 16;
    int giving = 0;
    double longest = 0;
    for (const DeviceLimits& device : known_devices()) {
        for (int delay = 0; delay <= 3; ++delay) {
            HandModel model = testing::without_hand();
            model.device_damping = 0.1;
            model.delay_ticks = delay;
            for (model.mass = 0.02; model.mass < 0.5; model.mass *= 1.05) {
                double ratio = 0;
                double contact = 0;
                for (int phase = 0; phase < phases; ++phase) {
                    const auto [each, seconds] = bounce(model, device.max_stiffness,
                                                        device.max_damping, (phase + 0.5) / phases);
                    ratio += each / phases;
                    contact += seconds / phases;
                }
                if (ratio <= 1) continue;
                ++giving;
                longest = std::max(longest, contact);
                EXPECT_LE(contact, 0.024) << device.name << ' ' << delay << ' ' << model.mass;
                EXPECT_FALSE(device.max_stiffness <= 1000 && model.mass > 0.06)
                    << device.name << ' ' << delay << ' ' << model.mass;
            }
        }
    }
    std::printf("longest contact of a fully damped wall that gives energy: %.1f ms\n",
                1e3 * longest);
    EXPECT_GT(giving, 10);
}

/// A motion along x of so many turns per second, whose amplitude grows by so much a turn, up to e^2.
/// Calls visit(seconds, tick) until it returns false.
template <class Visit>
void watch_swing(double per_second, double growth, double encoder_step, Visit&& visit)
{
    SwingDetector detector;
    for (int tick = 0; tick < 2000; ++tick) {
        const double t = 1e-3 * tick;
        const double size = 5e-4 * std::exp(std::clamp(2 * per_second * growth * t, -9.0, 2.0));
        double x = size * std::sin(2 * 3.14159265358979 * per_second * t + 0.3);
        if (encoder_step > 0) x = std::round(x / encoder_step) * encoder_step;
        if (!visit(t, detector.watch(Vec3(x, 0, 0), Vec3(-500 * x, 0, 0), 1e-3))) return;
    }
}

TEST(SwingDetector, ReportsGrowingSwingsWithinTwelveTurnsAtAnyRate)
{
    for (double per_second = 3; per_second < 200; per_second *= 1.03) {
        for (const double encoder_step : {0.0, 5e-5}) {
            double seen = -1;
            bool fast = false;
            watch_swing(per_second, 0.1, encoder_step, [&](double t, const SwingTick& tick) {
                if (!tick.reported || tick.legs < 3) return true;
                seen = t;
                fast = tick.fast;
                return false;
            });
            EXPECT_GE(seen, 0) << per_second << ' ' << encoder_step;
            EXPECT_LT(seen * 2 * per_second, 12) << per_second << ' ' << encoder_step;
            EXPECT_TRUE(per_second > 12 || !fast) << per_second;
            EXPECT_TRUE(per_second < 25 || fast) << per_second;
        }
    }
}

TEST(SwingDetector, ReportsNoSwingThatFades)
{
    // Near half the rate of the ticks the sampled turns of a swing beat.
    for (double per_second = 3; per_second < 80; per_second *= 1.03) {
        for (const double encoder_step : {0.0, 5e-5}) {
            watch_swing(per_second, -0.2, encoder_step, [&](double t, const SwingTick& tick) {
                const bool wrong = tick.reported && tick.legs > 1;
                EXPECT_FALSE(wrong) << per_second << ' ' << encoder_step << ' ' << t;
                return !wrong;
            });
        }
    }
}

TEST(SwingDetector, CountsTheTimeInContactOfACycle)
{
    // Ten times a second, below z = 0 for half of the time and below -1 mm for a third of it.
    constexpr double depth = 0.002;
    constexpr double limit = 500 * depth / 2;
    for (const double most_force : {1e9, limit}) {
        SwingDetector detector;
        int reports = 0;
        for (int tick = 0; tick < 1000; ++tick) {
            const double size = depth * (1 + 0.1 * tick / 1000);
            const double z = size * std::sin(2 * std::numbers::pi * 10 * 1e-3 * tick);
            const Vec3 force(0, 0, 500 * std::max(-z, 0.0));
            const SwingTick seen = detector.watch(Vec3(0, 0, z), force, 1e-3, most_force);
            if (!seen.reported || tick < 300) continue;
            ++reports;
            const double within = std::asin(limit / (500 * size)) / std::numbers::pi;
            EXPECT_NEAR(seen.contact, 0.1 * (most_force > limit ? 0.5 : within), 0.003) << tick;
        }
        EXPECT_GT(reports, 5);
    }
}

TEST(SwingDetector, ForgetsMotionAwayFromTheSurface)
{
    SwingDetector detector;
    EXPECT_TRUE(detector.is_away());
    for (int tick = 0; tick < 400; ++tick)
        (void)detector.watch(Vec3(1e-3 * std::sin(0.1 * tick), 0, 0), Vec3(1, 0, 0), 1e-3);
    EXPECT_TRUE(detector.is_swinging());
    EXPECT_FALSE(detector.is_away());
    for (int tick = 0; tick < 400; ++tick) {
        const SwingTick seen = detector.watch(Vec3(tick * 1e-3, 0, 0), Vec3::Zero(), 1e-3);
        EXPECT_FALSE(tick > 251 && seen.reported) << tick;
    }
    EXPECT_TRUE(detector.is_away());
}

TEST(BounceDetector, TellsSpeedsBesideAContactAndItsTimes)
{
    // Straight down to z = 0 at 0.3 m/s, 20 ms in contact, of these 8 at the force's limit, and up at 0.4.
    BounceDetector detector;
    int touched = 0;
    int left = 0;
    for (int tick = -400; tick < 400; ++tick) {
        const double t = 1e-3 * tick;
        const bool contact = tick >= 0 && tick < 20;
        const double z = tick < 0 ? -0.3 * t : contact ? -1e-3 : 0.4 * (t - 0.02);
        // A contact before, so that there is a flight.
        const bool before = tick < -380;
        const double force = contact ? (tick >= 6 && tick < 14 ? 3.0 : 1.0) : before ? 1.0 : 0.0;
        const Bounce seen =
            detector.watch(Vec3(0.1, 0, z), Vec3(0, 0, force), Vec3::Zero(), 1e-3, 3);
        if (seen.touched) {
            ++touched;
            EXPECT_EQ(tick, 0);
        }
        if (!seen.left) continue;
        ++left;
        EXPECT_NEAR(seen.speed_in, 0.3, 1e-9);
        EXPECT_NEAR(seen.speed_out, 0.4, 1e-9);
        EXPECT_NEAR(seen.contact, 0.012, 1e-9);
        EXPECT_NEAR(seen.flight, 0.381, 1e-9);
        EXPECT_GT(tick, 30); // a force that is late has ended, and the account is complete
        EXPECT_LT(tick, 40);
    }
    EXPECT_EQ(touched, 1);
    EXPECT_EQ(left, 1);
    EXPECT_TRUE(detector.is_bouncing());
    for (int tick = 0; tick < 300; ++tick)
        (void)detector.watch(Vec3::Zero(), Vec3(0, 0, 1), Vec3::Zero(), 1e-3, 3);
    EXPECT_FALSE(detector.is_bouncing()); // it rests
}

TEST(BounceDetector, TakesAPressAtTheForcesLimitForNoBounce)
{
    BounceDetector detector;
    for (int tick = 0; tick < 100; ++tick)
        (void)detector.watch(Vec3(0, 0, 0.1 - 1e-3 * tick), Vec3::Zero(), Vec3::Zero(), 1e-3, 3);
    EXPECT_TRUE(detector.is_bouncing());
    for (int tick = 0; tick < 300; ++tick)
        (void)detector.watch(Vec3(0, 0, -1e-3), Vec3(0, 0, 3), Vec3::Zero(), 1e-3, 3);
    EXPECT_FALSE(detector.is_bouncing());
}

TEST(BounceDetector, TellsSpeedsAgainstASurfaceThatMoves)
{
    // It goes down at 0.1 m/s. In space the device comes at 0.4 and leaves at 0.3: against it at 0.3 and 0.4.
    BounceDetector detector;
    int left = 0;
    double relative = 0.2;
    for (int tick = 0; tick < 600; ++tick) {
        const bool contact = tick >= 500 && tick < 520;
        // Less the way of what is touched, which is known in contact alone.
        relative += contact ? 0 : tick < 500 ? -0.4e-3 : 0.3e-3;
        const Bounce seen =
            detector.watch(Vec3(0, 0, relative), Vec3(0, 0, contact ? 1 : 0),
                           contact ? Vec3(0, 0, -0.1) : Vec3(Vec3::Zero()), 1e-3, 3);
        if (!seen.left) continue;
        ++left;
        EXPECT_NEAR(seen.speed_in, 0.3, 1e-9);
        EXPECT_NEAR(seen.speed_out, 0.4, 1e-9);
    }
    EXPECT_EQ(left, 1);
}

TEST(BounceDetector, TakesAForceThatFlickersForOneContact)
{
    BounceDetector detector;
    int touched = 0;
    int left = 0;
    // In contact for 40 ticks. In every other ten of them there is no force.
    for (int tick = 0; tick < 600; ++tick) {
        const bool contact = tick >= 500 && tick < 540 && tick % 20 < 10;
        const double z = tick < 500 ? -0.3e-3 * tick : tick < 530 ? -0.15 : 0.4e-3 * (tick - 530);
        const Bounce seen =
            detector.watch(Vec3(0, 0, z), Vec3(0, 0, contact ? 1 : 0), Vec3::Zero(), 1e-3, 3);
        touched += seen.touched ? 1 : 0;
        if (!seen.left) continue;
        ++left;
        EXPECT_NEAR(seen.contact, 0.02, 1e-9);
        EXPECT_NEAR(seen.speed_in, 0.3, 1e-9);
        EXPECT_NEAR(seen.speed_out, 0.4, 1e-9);
    }
    EXPECT_EQ(touched, 1);
    EXPECT_EQ(left, 1);
    // A hand that hovers at a surface does not bounce: its contacts follow each other too soon to be told apart.
    for (int tick = 0; tick < 1500; ++tick) {
        (void)detector.watch(Vec3::Zero(), Vec3(0, 0, tick % 20 < 5 ? 1 : 0), Vec3::Zero(), 1e-3,
                             3);
    }
    EXPECT_FALSE(detector.is_bouncing());
}

TEST(BounceDetector, TellsNothingOfContactsWithoutAFlightOrThatTurn)
{
    BounceDetector detector;
    int told = 0;
    for (int tick = 0; tick < 2000; ++tick) { // in the air for 15 ticks of 20
        const Vec3 force(0, 0, tick % 20 < 5 ? 1 : 0);
        told += detector.watch(Vec3::Zero(), force, Vec3::Zero(), 1e-3, 3).left ? 1 : 0;
    }
    EXPECT_EQ(told, 0);
    for (int tick = 0; tick < 2000; ++tick) { // in the air for long, but the force turns
        const int phase = tick % 400;
        const Vec3 force(phase < 5 ? 1 : 0, 0, phase >= 5 && phase < 10 ? 1 : 0);
        told += detector.watch(Vec3::Zero(), force, Vec3::Zero(), 1e-3, 3).left ? 1 : 0;
    }
    EXPECT_EQ(told, 0);
}

/// A wall of stiffness 500, whose forces act after some ticks, along a path by the clock. Returns what
/// the account finds for that delay, and the exact energy.
std::array<double, 2> given_on_a_path(int delay, double damping, double encoder_step)
{
    EnergyAccount account;
    std::array<Vec3, 8> forces{};
    double exact = 0;
    double before = 0.5e-3;
    double reported_before = before;
    const auto height = [](int tick) { return 1e-3 * std::cos(0.05 * tick) - 0.5e-3; };
    constexpr int period = 1257; // ten
    for (int tick = 0; tick < period; ++tick) {
        const double z = height(tick);
        const double reported = encoder_step > 0 ? std::round(z / encoder_step) * encoder_step : z;
        const Vec3 spring(0, 0, 500 * std::max(-reported, 0.0));
        const double v = (reported - reported_before) / 1e-3;
        const Vec3 force = spring - Vec3(0, 0, reported < 0 ? damping * v : 0.0);
        exact += forces[static_cast<std::size_t>((tick - 1 - delay + 16) % 8)].z() * (z - before);
        forces[static_cast<std::size_t>(tick % 8)] = force;
        account.add(Vec3(0, 0, reported), spring, 1e-3);
        account.applied(force);
        before = z;
        reported_before = reported;
    }
    return {account.sums().own.given[static_cast<std::size_t>(delay)], exact};
}

TEST(EnergyAccount, FindsTheEnergyOfAClosedPathForEachDelay)
{
    for (int delay = 0; delay <= 3; ++delay) {
        for (const double damping : {0.0, 1.0, 3.0}) {
            for (const double encoder_step : {0.0, 1e-5}) {
                const auto [given, exact] = given_on_a_path(delay, damping, encoder_step);
                // Ten cycles; what a window of ten ticks spreads is a hundredth of the spring's work.
                EXPECT_NEAR(given, exact, 0.05 * std::abs(exact) + 2e-5)
                    << delay << ' ' << damping << ' ' << encoder_step;
            }
        }
    }
}

} // namespace
} // namespace proxima::wall_swing_test
