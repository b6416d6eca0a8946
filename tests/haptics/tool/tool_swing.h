// A simulated hand that holds a tool against objects: what swings, and how far.
//
//     linear     the device's tip, a mass: SimulatedHand in metres and newtons
//     angular    its handle, a solid with the same moment of inertia about every axis: SimulatedHand
//                in radians and newton metres
#pragma once

#include "haptics/tool/rigid_motion.h"
#include "haptics/tool/tool_bench.h"
#include "haptics/tool/tool_guard.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"
#include "proxima/sample_meshes.h"
#include "proxima/tool_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <span>
#include <utility>
#include <vector>

namespace proxima::testing {

/// A hand that moves and turns a device.
class TurningHand {
public:
    TurningHand(const HandModel& model, double gyration, const RigidTransform& at)
        : linear_(model, at.translation), angular_(turning(model, gyration), Vec3::Zero()),
          rotation_(at.rotation)
    {}

    /// What the device reports: the rotation without steps of an encoder.
    [[nodiscard]] DeviceState state() const
    {
        DeviceState state = linear_.state();
        state.pose.rotation = rotation_;
        return state;
    }

    /// Advances by a tick towards a position, and an angle that counts from the first rotation.
    void step(const Vec3& force, const Vec3& torque, const Vec3& target, const Vec3& target_angle)
    {
        const Vec3 before = angular_.position();
        linear_.step(force, target);
        angular_.step(torque, target_angle);
        rotation_ =
            moved_by({rotation_, Vec3::Zero()}, {Vec3::Zero(), angular_.position() - before}, 1)
                .rotation;
    }

    [[nodiscard]] const Vec3& position() const { return linear_.position(); }
    /// All turns so far, added up, rad.
    [[nodiscard]] const Vec3& angle() const { return angular_.position(); }

private:
    static HandModel turning(HandModel model, double gyration)
    {
        const double square = gyration * gyration;
        model.mass *= square;
        model.device_damping *= square;
        model.hand_stiffness *= square;
        model.hand_damping *= square;
        model.coulomb_friction *= gyration;
        model.encoder_step = 0;
        return model;
    }

    SimulatedHand linear_;
    SimulatedHand angular_;
    Mat3 rotation_;
};

/// How a tool touches: what it stands on, or is in.
enum class ToolStand : int { face, edge, corner, groove, hole, fit };
inline constexpr std::array tool_stands = {ToolStand::face,   ToolStand::edge, ToolStand::corner,
                                           ToolStand::groove, ToolStand::hole, ToolStand::fit};
inline constexpr std::array<const char*, 6> tool_stand_names = {"face",   "edge", "corner",
                                                                "groove", "hole", "fit"};

/// A tool and an object, in metres, and the pose in which they just touch.
struct ToolScene {
    MeshIndex tool;
    ToolObject object;
    RigidTransform touching;
    bool encloses = false; ///< the hand need not press
};

inline ToolScene make_tool_scene(ToolStand stand)
{
    constexpr double half = 0.01;
    const TriangleMesh box = box_mesh(Vec3::Constant(half));
    const auto on_table = [&](const RigidTransform& touching) {
        return ToolScene{
            index_of(box), {index_of(box_mesh({0.1, 0.1, 0.05}, {0, 0, -0.05})), {}}, touching};
    };
    switch (stand) {
    case ToolStand::face:
        return on_table(pose_at({0, 0, half}));
    case ToolStand::edge:
        return on_table(pose_at({0, 0, half * std::numbers::sqrt2}, {std::numbers::pi / 4, 0, 0}));
    case ToolStand::corner:
        return on_table(pose_at({0, 0, half * std::sqrt(3.0)},
                                std::acos(1 / std::sqrt(3.0)) * Vec3(1, -1, 0).normalized()));
    case ToolStand::groove:
        return {index_of(moved(*sample_mesh("icosphere:3"),
                               [&](const Vec3& p) { return Vec3(half * p); })),
                {index_of(groove_mesh()), {}},
                pose_at({0, 0, half * std::numbers::sqrt2})};
    case ToolStand::hole:
    case ToolStand::fit:
        break;
    }
    constexpr double side = 0.005;
    const double room = stand == ToolStand::hole ? 5e-4 : 1.2e-5;
    return {index_of(box_mesh({side, side, 0.015})),
            {index_of(block_with_hole(side, room, 0.03)), {}},
            RigidTransform{},
            true};
}

struct ToolSwingSetting {
    DeviceLimits device;
    double stiffness = 500;
    double damping = 0;
    double lever = turning_lever; ///< m: torsional stiffness and damping are those times its square
    double friction = 0;
    HandModel hand;
    double gyration = turning_lever; ///< m, of the handle
    double press = 0;                ///< m: how far below the touching pose the hand pulls
    Guard guard = Guard::on;
    std::uint64_t seed = 1; ///< of the directions in which the tool is let go
};

struct ToolSwingResult {
    double amplitude = 0; ///< m: half of the way to and fro in half a second of the end, the most
    double angle = 0;     ///< rad, likewise
    double checksum = 0;  ///< of all forces and torques
    SwingReport report;
};

/// Half of the range of a motion, the most of the three axes.
class MotionRange {
public:
    void restart(const Vec3& p) { low_ = high_ = p; }
    void add(const Vec3& p)
    {
        low_ = low_.cwiseMin(p);
        high_ = high_.cwiseMax(p);
    }
    [[nodiscard]] double half() const { return (high_ - low_).maxCoeff() / 2; }

private:
    Vec3 low_ = Vec3::Zero();
    Vec3 high_ = Vec3::Zero();
};

/// Lets the tool go a millimetre from where it touches, and turned by as much at the lever; the end is
/// the last two of some seconds.
inline ToolSwingResult swing(const ToolScene& scene, const ToolSwingSetting& setting,
                             double seconds)
{
    ToolRenderOptions options;
    options.force.stiffness = setting.stiffness;
    options.force.damping = setting.damping;
    options.torsional_stiffness = setting.stiffness * setting.lever * setting.lever;
    options.torsional_damping = setting.damping * setting.lever * setting.lever;
    options.static_friction = options.dynamic_friction = setting.friction;
    options.guard = setting.guard;
    ToolRenderer renderer = make_tool_renderer(scene.tool, std::span(&scene.object, 1),
                                               WorkspaceMap{}, setting.device, options)
                                .value();
    // The ramp of the start is over when the hand lets go.
    DeviceState rest;
    rest.pose = scene.touching;
    if (!scene.encloses) rest.pose.translation.z() += 1e-3;
    for (int tick = 0; tick < 300; ++tick) (void)renderer.tick(rest, tick_seconds);
    std::mt19937_64 random(setting.seed);
    std::normal_distribution<double> normal;
    const auto direction = [&] {
        return Vec3(normal(random), normal(random), normal(random)).normalized();
    };
    Vec3 push = direction();
    if (!scene.encloses) push.z() = -std::abs(push.z());
    const Vec3 turn = 1e-3 / setting.lever * direction();
    TurningHand hand(setting.hand, setting.gyration,
                     moved_by(scene.touching, {1e-3 * push, turn}, 1));
    const Vec3 target = scene.touching.translation - setting.press * Vec3::UnitZ();
    ToolSwingResult result;
    MotionRange way;
    MotionRange turns;
    const int ticks = static_cast<int>(std::lround(seconds / tick_seconds));
    for (int tick = 0; tick < ticks; ++tick) {
        const ToolTick& felt = renderer.tick(hand.state(), tick_seconds);
        hand.step(felt.force, felt.torque, target, -turn);
        result.checksum += (felt.force.sum() + felt.torque.sum()) * (tick % 1000 + 1);
        if (!(hand.position().norm() < 0.5 && hand.angle().norm() < 10)) { // out of any hand
            result.amplitude = hand.position().norm();
            result.angle = hand.angle().norm();
            break;
        }
        if (tick < ticks - 2000) continue;
        if (tick % 500 == 0) {
            way.restart(hand.position());
            turns.restart(hand.angle());
        }
        way.add(hand.position());
        turns.add(hand.angle());
        result.amplitude = std::max(result.amplitude, way.half());
        result.angle = std::max(result.angle, turns.half());
    }
    result.report = guard_of(renderer).passivity().report();
    return result;
}

} // namespace proxima::testing
