// Friction of tools against closed forms, tools at rest, and the energy of closed paths.
#include "haptics/tool/rigid_motion.h"
#include "haptics/tool/tool_on_table.h"
#include "proxima/sample_meshes.h"
#include "proxima/tool_renderer.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <iostream>
#include <numbers>
#include <random>
#include <string>

namespace proxima::testing::tool_friction_test {
namespace {

using namespace tool_on_table;

ToolBench box_on_table(double fixed, double sliding)
{
    ToolBench bench(box_mesh(Vec3::Constant(half)), {{index_of(table()), {}}},
                    springs_with_friction(fixed, sliding));
    bench.start(pose_at({0, 0, 0.02}));
    return bench;
}

/// On a slope the device pulls the box straight down, as weight does.
TEST(ToolFriction, OnASlopeItSticksWhereFrictionIsMoreThanItsTangentAndSlidesWhereItIsLess)
{
    for (const double degrees : {5.0, 15.0, 25.0, 35.0}) {
        const double angle = degrees * std::numbers::pi / 180;
        const RigidTransform slope = pose_at(Vec3::Zero(), {0, angle, 0});
        const Vec3 normal = slope.rotation.col(2);
        for (const double part : {0.98, 1.02}) {
            const double friction = part * std::tan(angle);
            SCOPED_TRACE(std::to_string(degrees) + " degrees, friction " +
                         std::to_string(friction));
            ToolBench bench(box_mesh(Vec3::Constant(half)), {{index_of(table()), slope}},
                            springs_with_friction(friction, friction));
            RigidTransform device = slope;
            device.translation = (half + 10 * clearance) * normal;
            bench.start(device);
            device.translation.z() -= 0.004;
            const ToolTick& tick = bench.lead(device, 100);
            const double across = tick.force.dot(normal);
            const double along = (tick.force - across * normal).norm();
            EXPECT_GT(across, 1);
            if (part > 1) {
                // Straight up: it stays where it touched.
                EXPECT_LT(tick.force.head<2>().norm(), 1e-3 * across);
                EXPECT_NEAR(along, std::tan(angle) * across, 1e-3 * across);
            } else {
                EXPECT_NEAR(along, friction * across, 1e-5 * across);
            }
            EXPECT_LT(twist_between(slope, tick.proxy).angular.norm(), 1e-6);
            EXPECT_FALSE(bench.meets());
        }
    }
}

TEST(ToolFriction, APulledBoxLagsByItsFrictionOverTheStiffness)
{
    const double depth = 0.003;
    const double load = stiffness * (depth + clearance);
    for (const double friction : {0.1, 0.3, 0.7}) {
        for (const double direction : {0.0, 0.4, 2.5}) {
            ToolBench bench = box_on_table(friction, friction);
            (void)bench.lead(pose_at({0, 0, half - depth}), 50);
            const Vec3 along(std::cos(direction), std::sin(direction), 0);
            // As far as friction holds it, it stays.
            const double held = 0.95 * friction * load / stiffness;
            const RigidTransform before = bench.renderer().last().proxy;
            const ToolTick& stuck =
                bench.lead(pose_at(Vec3(0, 0, half - depth) + held * along), 50);
            EXPECT_EQ(stuck.hold, Hold::sticking);
            EXPECT_EQ(stuck.proxy.translation, before.translation);
            const ToolTick& tick =
                bench.lead(pose_at(Vec3(0, 0, half - depth) + 0.02 * along), 200, 1);
            EXPECT_EQ(tick.hold, Hold::sliding);
            EXPECT_NEAR(tick.force.z(), load, force_error);
            EXPECT_LT((tick.force.head<2>() + friction * load * along.head<2>()).norm(),
                      10 * force_error);
        }
    }
}

TEST(ToolFriction, ItYieldsAtStaticAndSlidesAtDynamicFriction)
{
    const double depth = 0.003;
    const double load = stiffness * (depth + clearance);
    ToolBench bench = box_on_table(0.5, 0.4);
    (void)bench.lead(pose_at({0, 0, half - depth}), 50);
    double most = 0;
    for (int i = 0; i < 400; ++i) {
        const ToolTick& tick = bench.tick(pose_at({1e-5 * i, 0, half - depth}));
        const double ratio = -tick.force.x() / tick.force.z();
        most = std::max(most, ratio);
        if (tick.hold == Hold::sliding) {
            ASSERT_NEAR(ratio, 0.4, 1e-4) << i;
        }
    }
    EXPECT_EQ(bench.renderer().last().hold, Hold::sliding);
    // Within a step of the device.
    EXPECT_LE(most, 0.5);
    EXPECT_GT(most, 0.5 - stiffness * 1e-5 / load);
}

/// A ball in a groove of 90 degrees bears F / sqrt(2) on either side, and friction on both.
TEST(ToolFriction, ABallAlongAGrooveIsHeldBackByBothSides)
{
    const double radius = 0.01;
    const double friction = 0.2;
    const TriangleMesh ball =
        moved(*sample_mesh("icosphere:4"), [&](const Vec3& p) { return Vec3(radius * p); });
    const TriangleMesh groove = groove_mesh();
    ToolBench bench(ball, {{index_of(groove), {}}}, springs_with_friction(friction, friction));
    bench.start(pose_at({0, -0.02, 0.04}));
    const double device = radius * std::numbers::sqrt2 - 0.003;
    (void)bench.lead(pose_at({0, -0.02, device}), 100, 50);
    const ToolTick& tick = bench.lead(pose_at({0, 0.02, device}), 400, 1);
    EXPECT_EQ(tick.hold, Hold::sliding);
    const double pressed = tick.force.z() * std::numbers::sqrt2; // on both sides together
    EXPECT_NEAR(tick.force.y(), -friction * pressed, 0.03 * friction * pressed);
    // Friction acts radius / sqrt(2) below the centre.
    const double torque = friction * pressed * radius / std::numbers::sqrt2;
    EXPECT_NEAR(tick.torque.x(), -torque, 0.05 * torque);
    EXPECT_FALSE(bench.meets());
}

/// All corners of a box are as far from its middle, so the moment of friction is mu N R however they
/// share the load.
TEST(ToolFriction, AFlatPatchResistsTurning)
{
    const double depth = 0.004;
    const double load = stiffness * (depth + clearance);
    const double friction = 0.3;
    const double moment = friction * load * half * std::numbers::sqrt2;
    ToolBench bench = box_on_table(friction, friction);
    (void)bench.lead(pose_at({0, 0, half - depth}), 50);
    const double held = 0.9 * moment / torsional;
    const ToolTick& stuck = bench.lead(pose_at({0, 0, half - depth}, {0, 0, held}), 50);
    EXPECT_NEAR(stuck.torque.z(), -torsional * held, 1e-9);
    EXPECT_EQ(stuck.hold, Hold::sticking);
    const ToolTick& tick = bench.lead(pose_at({0, 0, half - depth}, {0, 0, 0.2}), 100, 1);
    EXPECT_NEAR(tick.torque.z(), -moment, 1e-3 * moment);
    EXPECT_NEAR(tick.force.z(), load, force_error);
    EXPECT_EQ(tick.hold, Hold::sliding);
}

/// Random motions in contact, and then a device that holds still.
TEST(ToolFriction, AToolThatIsHeldStillHasAForceThatDoesNotChange)
{
    const TriangleMesh ball =
        moved(*sample_mesh("icosphere:3"), [](const Vec3& p) { return Vec3(0.03 * p); });
    const TriangleMesh ring =
        moved(*sample_mesh("torus:32x16"), [](const Vec3& p) { return Vec3(0.03 * p); });
    int touching = 0;
    for (const bool on_ring : {false, true}) {
        const MeshIndex object = index_of(on_ring ? ring : ball);
        for (std::uint32_t seed = 1; seed <= 8; ++seed) {
            SCOPED_TRACE(std::to_string(seed) + (on_ring ? ", ring" : ", ball"));
            std::mt19937 random(seed);
            const auto vector = [&] { return random_vector(random); };
            ToolBench bench(box_mesh({0.01, 0.006, 0.004}), {{object, {}}},
                            springs_with_friction(0.5, 0.4));
            bench.start(pose_at({0, 0.03, 0.05}));
            for (int leg = 0; leg < 3; ++leg) {
                const Vec3 aside = Vec3(0.01, 0.01, 0.005).cwiseProduct(vector());
                (void)bench.lead(pose_at(Vec3(0, 0.02, 0.02) + aside, 0.5 * vector()), 60, 0);
            }
            for (int i = 0; i < 100; ++i) bench.tick(bench.device());
            const ToolTick rest = bench.renderer().last();
            touching += rest.contact_count > 0 ? 1 : 0;
            for (int i = 0; i < 200; ++i) {
                const ToolTick& tick = bench.tick(bench.device());
                ASSERT_EQ(tick.force, rest.force) << i;
                ASSERT_EQ(tick.torque, rest.torque) << i;
            }
            EXPECT_FALSE(bench.meets());
        }
    }
    std::cout << touching << " of 16 touch\n";
    EXPECT_GE(touching, 8);
}

/// Round and round in contact: friction takes energy on every path.
TEST(ToolFriction, ClosedPathsTakeEnergy)
{
    const ToolObject object = {
        index_of(moved(*sample_mesh("icosphere:3"), [](const Vec3& p) { return Vec3(0.03 * p); })),
        {}};
    for (const double friction : {0.02, 0.1, 0.5}) {
        for (const double size : {0.0005, 0.002, 0.004}) {
            ToolBench bench(box_mesh({0.01, 0.006, 0.004}), {object},
                            springs_with_friction(friction, 0.8 * friction));
            const int steps = 1000;
            const auto pose = [&](int step) {
                const double part = step / static_cast<double>(steps);
                const double down = 0.5 * (1 - std::cos(2 * std::numbers::pi * part));
                const double angle = 4 * std::numbers::pi * part;
                return pose_at(
                    {size * std::sin(angle), size * (1 - std::cos(angle)), 0.036 - 0.004 * down},
                    Vec3(25 * size * std::sin(angle), 37 * size * std::sin(2 * angle),
                         20 * size * std::cos(angle)));
            };
            bench.start(pose(0));
            ToolTick before = bench.renderer().last();
            double work = 0; // of the springs on the device
            double most = 0; // that they stored
            for (int step = 1; step <= steps; ++step) {
                const ToolTick tick = bench.tick(pose(step));
                const Twist moved = twist_between(before.device, tick.device);
                work += 0.5 * (before.spring_force + tick.spring_force).dot(moved.linear) +
                        0.5 * (before.spring_torque + tick.spring_torque).dot(moved.angular);
                most = std::max(most, 0.5 * tick.spring_force.squaredNorm() / stiffness);
                before = tick;
            }
            EXPECT_EQ(before.contact_count, 0U);
            std::cout << "friction " << friction << ", path of " << 1e3 * size
                      << " mm: " << 1e6 * work << " uJ of at most " << 1e6 * most << " uJ stored\n";
            EXPECT_LT(work, 0);
        }
    }
}

} // namespace
} // namespace proxima::testing::tool_friction_test
