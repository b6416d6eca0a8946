// Sessions in which nothing is unstable: hands that tap, tremble, press and write, through the input
// guard and the whole renderer. Forces must neither fade nor be softened, however long they last.
//
//     imposed     the motion does not yield: a stiff arm, or a robot that leads the hand
//     held        a simulated hand of 150 to 1,500 N/m leads a device along the motion
#pragma once

#include "haptics/servo_tick.h"
#include "haptics/wall_swing.h"

#include "haptics/force/swing_bounces.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace proxima::testing {

/// Where the tip is, or the hand wants it, in a tick; the wall is at z = 0. Called tick by tick.
using HandMotion = std::function<Vec3(double seconds)>;

struct HandSession {
    std::string name;
    DeviceLimits device;
    double stiffness = 500;
    double damping = 1;
    double encoder_step = 0;
    std::optional<HandModel> hand; ///< none: the motion is imposed
    HandMotion path;
};

struct HandOutcome {
    SwingReport swings;
    InputReport input;
    double greatest_force = 0; ///< N
    double damped = 0;         ///< part of the ticks in which the guard added damping
    double taken = 0;          ///< by the guards, in the mean, in parts of the mean force
    int faster = 0;            ///< contacts that the device leaves by 2 % faster than it came
};

/// Taps of `depth` below the wall, of which `above` is the part of the way above it. A share `inward`
/// of each tap is the way in. Periods vary by 5 % and depths by 15 %, as a hand's do.
inline HandMotion tapping(double per_second, double depth, double above, double inward,
                          std::uint64_t seed)
{
    struct State {
        std::mt19937_64 random;
        double begin = 0;
        double period = 0;
        double size = 1;
    };
    return [=, state = State{std::mt19937_64(seed)}](double seconds) mutable {
        std::normal_distribution<double> normal;
        if (state.period == 0 || seconds >= state.begin + state.period) {
            state.begin += state.period;
            state.period = std::exp(0.05 * normal(state.random)) / per_second;
            state.size = std::exp(0.15 * normal(state.random));
        }
        const double phase = (seconds - state.begin) / state.period;
        const double down = phase < inward
                                ? 1 - std::cos(std::numbers::pi * phase / inward)
                                : 1 + std::cos(std::numbers::pi * (phase - inward) / (1 - inward));
        const double way = depth / (1 - above);
        return Vec3(0, 0, above * way - state.size * way * down / 2);
    };
}

/// To a depth at one speed, held there for half a second, and up to a height at another speed.
inline HandMotion pressing(double height, double depth, double speed_in, double speed_out)
{
    return [=](double seconds) {
        constexpr double hold = 0.5;
        const double way = height + depth;
        const double phase =
            std::fmod(seconds, way / speed_in + hold + way / speed_out) - way / speed_in;
        const double below =
            phase < 0 ? way + speed_in * phase : way - speed_out * std::max(phase - hold, 0.0);
        return Vec3(0, 0, height - below);
    };
}

/// A tremor in contact, below a hand that presses.
inline HandMotion trembling(double per_second, double amplitude, double depth)
{
    return [=](double seconds) {
        const double swell = 1 + 0.3 * std::sin(2 * std::numbers::pi * 0.37 * seconds);
        const double z = std::sin(2 * std::numbers::pi * per_second * seconds);
        return Vec3(0, 0, -depth + amplitude * swell * z);
    };
}

/// Strokes of 20 mm, lifted after each, with a tremor of 0.1 mm.
inline HandMotion writing(double strokes_per_second)
{
    return [=](double seconds) {
        const double angle = 2 * std::numbers::pi * strokes_per_second * seconds;
        const double lift = std::sin(angle / 4);
        const double tremor = 1e-4 * std::sin(2 * std::numbers::pi * 9 * seconds);
        return Vec3(0.01 * std::sin(angle), 0.002 * std::cos(angle),
                    -0.002 + 0.004 * std::max(lift - 0.8, 0.0) / 0.2 + tremor);
    };
}

inline HandMotion resting(double depth)
{
    return [=](double seconds) { return Vec3(0, 0, -depth * std::min(seconds, 1.0)); };
}

/// The sessions of a device at a stiffness. Imposed motions reach 80 % of its force at most. Hands
/// that are held are those for which theory has the wall stable by a third.
inline std::vector<HandSession> hand_sessions(const DeviceLimits& device, double stiffness,
                                              std::uint64_t seed)
{
    std::vector<HandSession> sessions;
    const auto add = [&](const std::string& name, double encoder_step,
                         const std::optional<HandModel>& hand, HandMotion path) {
        const std::string whole =
            std::string(device.name) + " K " + std::to_string(static_cast<int>(stiffness)) + ' ' +
            name + (encoder_step > 0 ? " coarse" : "") +
            (hand ? " hand " + std::to_string(static_cast<int>(hand->hand_stiffness)) : "");
        sessions.push_back({whole, device, stiffness, 1, encoder_step, hand, std::move(path)});
    };
    const double deepest = 0.8 * device.max_force / stiffness;
    for (const double encoder_step : {0.0, 5e-5}) {
        for (const double rate : {1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0}) {
            for (const double inward : {0.5, 0.55}) {
                for (const double depth : {0.001, 0.004}) {
                    const std::string name = "taps " + std::to_string(static_cast<int>(rate)) +
                                             " Hz " + std::to_string(depth) + ' ' +
                                             std::to_string(inward);
                    add(name, encoder_step, std::nullopt,
                        tapping(rate, std::min(depth, deepest), 0.5, inward, seed));
                }
            }
        }
        for (const double rate : {4.0, 6.0, 8.0, 10.0, 12.0}) {
            for (const double amplitude : {1e-4, 5e-4, 1e-3}) {
                add("trembles " + std::to_string(static_cast<int>(rate)) + " Hz " +
                        std::to_string(amplitude),
                    encoder_step, std::nullopt,
                    trembling(rate, amplitude, std::min(0.002, deepest)));
            }
        }
        add("writes", encoder_step, std::nullopt, writing(2));
        add("rests", encoder_step, std::nullopt, resting(std::min(0.004, deepest)));
        for (const double hand_stiffness : {150.0, 500.0, 1000.0, 1500.0}) {
            for (const double friction : {0.0, 0.05}) {
                HandModel hand;
                hand.hand_stiffness = hand_stiffness;
                hand.hand_damping = std::sqrt(hand_stiffness * hand.mass); // half of critical
                hand.coulomb_friction = friction;
                hand.encoder_step = encoder_step;
                const double late = hand.tick_seconds / 2;
                if ((stiffness + hand_stiffness) * late > 2.0 / 3 * (hand.device_damping + 1))
                    continue;
                for (const double rate : {2.0, 4.0, 7.0, 10.0}) {
                    add("taps " + std::to_string(static_cast<int>(rate)) + " Hz", encoder_step,
                        hand, tapping(rate, 0.006, 0.5, 0.55, seed));
                }
                for (const double rate : {4.0, 8.0, 12.0}) {
                    add("trembles " + std::to_string(static_cast<int>(rate)) + " Hz", encoder_step,
                        hand, trembling(rate, 1e-3, 0.005));
                }
                add("writes", encoder_step, hand, writing(2));
                add("rests", encoder_step, hand, resting(0.01));
            }
        }
    }
    return sessions;
}

/// Touches a wall. The first quarter of a second is above it, while the force ramps up.
inline HandOutcome run_hand_session(const SwingWall& wall, const HandSession& session,
                                    double seconds, Guard guard = Guard::on)
{
    RenderOptions options;
    options.force.stiffness = session.stiffness;
    options.force.damping = session.damping;
    options.guard = guard;
    HapticRenderer renderer =
        make_surface_renderer(wall.surface(), SwingWall::map(), session.device, options);
    DeviceInput input = make_device_input({.limits = session.device}).value();
    const Vec3 start(0, 0, 0.002);
    SimulatedHand hand(session.hand.value_or(HandModel{}), start);
    HandOutcome outcome;
    BounceDetector contacts;
    DeviceReading reading;
    Vec3 before = start;
    HandMotion path = session.path;
    double whole = 0;
    double taken = 0;
    const auto ticks = static_cast<std::int64_t>(std::llround(seconds / tick_seconds));
    for (std::int64_t tick = -300; tick < ticks; ++tick) {
        const double time = tick_seconds * static_cast<double>(tick);
        // From above the wall to where the motion begins, in the last tenth of a second.
        const double part = std::clamp(time / 0.1 + 1, 0.0, 1.0);
        const Vec3 target = start + part * (path(std::max(time, 0.0)) - start);
        if (session.hand) {
            reading.state = hand.state();
        } else {
            Vec3 position = target;
            if (session.encoder_step > 0) {
                position = (position / session.encoder_step).array().round() * session.encoder_step;
            }
            reading.state.pose.translation = position;
            reading.state.velocity = (position - before) / tick_seconds;
            before = position;
        }
        ++reading.sample;
        const RenderTick& felt = renderer.tick(input.accept(reading), tick_seconds);
        const DeviceCommand command = input.command(renderer);
        if (session.hand) hand.step(command.force, target);
        outcome.greatest_force = std::max(outcome.greatest_force, felt.force.norm());
        const Bounce contact = contacts.watch(felt.position, felt.force, Vec3::Zero(), tick_seconds,
                                              session.device.max_force);
        const bool fast = contact.left && contact.speed_in > 0.02;
        outcome.faster += fast && contact.speed_out > 1.02 * contact.speed_in ? 1 : 0;
        if (tick < 0) continue;
        const Vec3 spring = shortened(felt.spring, session.device.max_force);
        whole += spring.norm();
        taken += (felt.force - spring).norm();
    }
    if (whole > 0) outcome.taken = taken / whole;
    outcome.swings = parts_of(renderer).passivity().report();
    outcome.damped = static_cast<double>(outcome.swings.damped_ticks) / static_cast<double>(ticks);
    outcome.input = input.report();
    return outcome;
}

} // namespace proxima::testing
