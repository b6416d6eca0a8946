// Hands that tap, tremble, write, rest and turn a peg with a tool lose no force to softening, and
// little to damping.
#include "haptics/hand_sessions.h"
#include "haptics/tool/tool_guard.h"
#include "haptics/tool/tool_swing.h"
#include "proxima/device.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <gtest/gtest.h>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace proxima::testing::tool_sessions_test {
namespace {

struct ToolSession {
    std::string name;
    DeviceLimits device;
    std::optional<HandModel> hand; ///< none: the motion is imposed
    HandMotion path;               ///< m, from where the tool touches
    HandMotion turns;              ///< rad, from there
};

struct ToolOutcome {
    SwingReport swings;
    double damped = 0;        ///< part of the ticks
    double taken = 0;         ///< by the guard, in the mean, in parts of the mean force
    double taken_torque = 0;  ///< likewise
    double greatest_pull = 0; ///< N: of a force, or of a torque at the lever
};

constexpr double surface_stiffness = 700; // N/m, the most of an omni

ToolOutcome run(const ToolScene& scene, const ToolSession& session, double seconds)
{
    ToolRenderOptions options;
    options.force.stiffness = std::min(surface_stiffness, session.device.max_stiffness);
    options.torsional_stiffness = options.force.stiffness * turning_lever * turning_lever;
    options.torsional_damping = options.force.damping * turning_lever * turning_lever;
    ToolRenderer renderer = make_tool_renderer(scene.tool, std::span(&scene.object, 1),
                                               WorkspaceMap{}, session.device, options)
                                .value();
    RigidTransform start = scene.touching;
    if (!scene.encloses) start.translation.z() += 2e-3;
    TurningHand hand(session.hand.value_or(HandModel{}), turning_lever, start);
    HandMotion path = session.path;
    HandMotion turns = session.turns;
    ToolOutcome outcome;
    double whole = 0;
    double whole_torque = 0;
    const int ticks = static_cast<int>(std::lround(seconds / tick_seconds));
    for (int tick = -300; tick < ticks; ++tick) {
        const double time = tick_seconds * tick;
        // From above to where the motion begins, in the last tenth of a second.
        const double part = std::clamp(time / 0.1 + 1, 0.0, 1.0);
        const Vec3 wanted = scene.touching.translation + path(std::max(time, 0.0));
        const Vec3 target = start.translation + part * (wanted - start.translation);
        const Vec3 angle = part * turns(std::max(time, 0.0));
        DeviceState state = hand.state();
        if (!session.hand)
            state.pose = moved_by({start.rotation, target}, {Vec3::Zero(), angle}, 1);
        const ToolTick& felt = renderer.tick(state, tick_seconds);
        if (session.hand) hand.step(felt.force, felt.torque, target, angle);
        if (tick < 0) continue;
        const Vec3 force = shortened(felt.spring_force, session.device.max_force);
        const Vec3 torque = shortened(felt.spring_torque, session.device.max_torque);
        outcome.greatest_pull = std::max(
            {outcome.greatest_pull, felt.force.norm(), felt.torque.norm() / turning_lever});
        outcome.taken += (felt.force - force).norm();
        outcome.taken_torque += (felt.torque - torque).norm();
        whole += force.norm();
        whole_torque += torque.norm();
    }
    outcome.taken /= std::max(whole, 1e-9);
    outcome.taken_torque /= std::max(whole_torque, 1e-9);
    outcome.swings = guard_of(renderer).passivity().report();
    outcome.damped = static_cast<double>(outcome.swings.damped_ticks) / ticks;
    return outcome;
}

/// Turns about all three axes, not in step.
HandMotion wobbling(double per_second, double degrees)
{
    const double size = degrees * std::numbers::pi / 180;
    return [=](double seconds) {
        const double phase = 2 * std::numbers::pi * per_second * seconds;
        return Vec3(size * std::sin(phase), 0.7 * size * std::sin(phase + 1),
                    0.5 * size * std::sin(phase + 2));
    };
}

HandMotion waving(const Vec3& middle, const Vec3& along, double per_second)
{
    return [=](double seconds) {
        return Vec3(middle + std::sin(2 * std::numbers::pi * per_second * seconds) * along);
    };
}

std::vector<ToolSession> sessions_of(const DeviceLimits& device, ToolStand stand, bool encloses,
                                     std::uint64_t seed)
{
    std::vector<std::optional<HandModel>> hands = {std::nullopt};
    for (const double hand_stiffness : {150.0, 500.0}) {
        HandModel hand;
        hand.hand_stiffness = hand_stiffness;
        hand.hand_damping = std::sqrt(hand_stiffness * hand.mass); // half of critical
        hands.emplace_back(hand);
    }
    std::vector<ToolSession> sessions;
    for (const std::optional<HandModel>& hand : hands) {
        const auto add = [&](const std::string& what, HandMotion path, HandMotion turns) {
            const std::string who =
                hand ? std::to_string(static_cast<int>(hand->hand_stiffness)) : "imposed";
            sessions.push_back({std::string(device.name) + ' ' +
                                    tool_stand_names[static_cast<std::size_t>(stand)] + ' ' + what +
                                    ' ' + who,
                                device, hand, std::move(path), std::move(turns)});
        };
        const HandMotion still = [](double) { return Vec3(Vec3::Zero()); };
        if (encloses) {
            for (const double rate : {0.5, 1.0, 4.0}) {
                add("turns the peg " + std::to_string(rate) + " Hz", still,
                    waving(Vec3::Zero(), Vec3(0, 0, 0.3), rate));
            }
            add("moves the peg", waving(Vec3::Zero(), Vec3(0.001, 0, 0.005), 1), wobbling(1, 3));
            for (const double rate : {4.0, 12.0}) {
                add("trembles " + std::to_string(rate) + " Hz",
                    waving(Vec3(0.001, 0, 0), Vec3(5e-4, 0, 0), rate), wobbling(rate, 1));
            }
            add("rests", resting(0.002), waving(Vec3(0.05, 0, 0.1), Vec3::Zero(), 0));
            continue;
        }
        const double deep = 0.8 * device.max_force / surface_stiffness;
        for (const double rate : {1.0, 4.0, 10.0}) {
            add("taps " + std::to_string(rate) + " Hz",
                tapping(rate, hand ? 0.006 : std::min(0.004, deep), 0.5, 0.55, seed),
                wobbling(rate, 2));
        }
        for (const double rate : {4.0, 12.0}) {
            add("trembles " + std::to_string(rate) + " Hz",
                trembling(rate, 5e-4, hand ? 0.005 : std::min(0.002, deep)), wobbling(rate, 1));
        }
        add("writes", writing(2), wobbling(1, 5));
        add("rests", resting(hand ? 0.01 : std::min(0.004, deep)), wobbling(0.2, 3));
    }
    return sessions;
}

void expect_little_lost(const char* name)
{
    constexpr std::uint64_t seed = 4500;
    ::testing::Test::RecordProperty("seed", std::to_string(seed));
    DeviceLimits device = *find_device(name);
    device.max_torque = turning_lever * device.max_force;
    ToolOutcome mean;
    ToolOutcome most;
    double count = 0;
    for (const ToolStand stand : tool_stands) {
        const ToolScene scene = make_tool_scene(stand);
        for (const ToolSession& session : sessions_of(device, stand, scene.encloses, seed)) {
            const ToolOutcome outcome = run(scene, session, 5);
            EXPECT_EQ(outcome.swings.softened_ticks, 0U)
                << session.name << ", down to " << outcome.swings.lowest_softness;
            EXPECT_GT(outcome.greatest_pull, 0.05) << session.name;
            EXPECT_LE(outcome.taken, 0.25) << session.name;
            count += 1;
            mean.damped += outcome.damped;
            mean.taken += outcome.taken;
            mean.taken_torque += outcome.taken_torque;
            most.taken = std::max(most.taken, outcome.taken);
            most.taken_torque = std::max(most.taken_torque, outcome.taken_torque);
        }
    }
    mean.damped /= count;
    mean.taken /= count;
    mean.taken_torque /= count;
    std::printf("%s, %.0f sessions, seed %d: damped in %.1f %% of the ticks; force taken: "
                "%.2f %% in the mean, %.1f %% at most; torque %.2f %%, %.1f %%\n",
                name, count, static_cast<int>(seed), 100 * mean.damped, 100 * mean.taken,
                100 * most.taken, 100 * mean.taken_torque, 100 * most.taken_torque);
    EXPECT_GT(mean.damped, 0); // the guard sees them, and tries damping
    EXPECT_LE(mean.damped, 0.2);
    EXPECT_LE(mean.taken, 0.02);
    EXPECT_LE(mean.taken_torque, 0.06);
}

TEST(ToolSessions, OfAnOmniLoseNoForceToSofteningAndLittleToDamping)
{
    expect_little_lost("omni");
}

TEST(ToolSessions, OfADeltaLoseNoForceToSofteningAndLittleToDamping)
{
    expect_little_lost("delta");
}

} // namespace
} // namespace proxima::testing::tool_sessions_test
