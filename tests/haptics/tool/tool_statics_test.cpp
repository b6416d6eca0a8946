// Tools at rest against closed forms: positions, forces and torques.
#include "haptics/tool/tool_on_table.h"
#include "proxima/sample_meshes.h"
#include "proxima/tool_renderer.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace proxima::testing::tool_statics_test {
namespace {

using namespace tool_on_table;

constexpr double torque_error = torsional * settled / half;

ToolBench box_on_table()
{
    ToolBench bench(box_mesh(Vec3::Constant(half)), {{index_of(table()), {}}});
    bench.start(pose_at({0.003, 0.002, 0.02}));
    return bench;
}

TEST(ToolOnPlane, PushedDownItFeelsTheStretchAndNoTorque)
{
    ToolBench bench = box_on_table();
    const ToolTick& tick = bench.lead(pose_at({0.003, 0.002, half - 0.004}), 50);
    EXPECT_TRUE(tick.is_placed);
    EXPECT_NEAR(tick.force.z(), stiffness * (0.004 + clearance), force_error);
    EXPECT_LT(tick.force.head<2>().norm(), force_error);
    EXPECT_LT(tick.torque.norm(), torque_error);
    EXPECT_EQ(tick.end, ToolEnd::settled);
    EXPECT_FALSE(bench.meets());
}

TEST(ToolOnPlane, FreeToolsFeelNothingAndAreWhereTheDeviceIs)
{
    ToolBench bench = box_on_table();
    const RigidTransform device = pose_at({0.01, -0.02, 0.03}, {0.3, -0.2, 0.5});
    const ToolTick& tick = bench.lead(device, 40, 1);
    EXPECT_EQ(tick.force, Vec3(Vec3::Zero()));
    EXPECT_EQ(tick.torque, Vec3(Vec3::Zero()));
    EXPECT_EQ(tick.proxy.translation, device.translation);
}

/// Tilted by less than the contact can take, the face lies flat: the torsional spring alone turns.
TEST(ToolOnPlane, TiltedItLiesFlatAndFeelsTheTorsionalSpring)
{
    ToolBench bench = box_on_table();
    // The moment of the force about the middle is at most force * half.
    const double tilt = 0.02;
    ASSERT_LT(torsional * tilt, stiffness * 0.004 * half);
    const ToolTick& tick = bench.lead(pose_at({0, 0, half - 0.004}, {0, tilt, 0}), 50);
    EXPECT_NEAR(tick.torque.y(), -torsional * tilt, torque_error);
    EXPECT_NEAR(tick.force.z(), stiffness * (0.004 + clearance), force_error);
    double moment = 0; // of the contacts, about the proxy's origin
    double sum = 0;
    for (std::size_t i = 0; i < tick.contact_count; ++i) {
        const ToolContact& each = tick.contacts[i];
        sum += each.force;
        moment += (each.position - tick.proxy.translation).cross(each.force * each.normal).y();
    }
    EXPECT_NEAR(sum, tick.force.z(), force_error);
    EXPECT_NEAR(moment, tick.torque.y(), torque_error);
}

/// Tilted by more, it stands on an edge at the angle where spring and contact balance.
TEST(ToolOnPlane, TiltedFartherItStandsOnAnEdge)
{
    ToolBench bench = box_on_table();
    const double tilt = 0.3;
    const double depth = 0.002;
    const ToolTick& tick = bench.lead(pose_at({0, 0, half - depth}, {0, tilt, 0}), 100);
    // The edge is below the origin by h(a) = half (cos a + sin a): least energy of K/2 (h - z)^2 +
    // K_theta/2 (tilt - a)^2 over a, by bisection of the derivative.
    const double z = half - depth;
    const auto height = [](double a) { return half * (std::cos(a) + std::sin(a)) + clearance; };
    const auto slope = [&](double a) {
        return stiffness * (height(a) - z) * half * (std::cos(a) - std::sin(a)) -
               torsional * (tilt - a);
    };
    double low = 0;
    double high = tilt;
    ASSERT_LT(slope(low), 0);
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (slope(middle) < 0 ? low : high) = middle;
    }
    EXPECT_NEAR(tick.force.z(), stiffness * (height(low) - z), 10 * force_error);
    EXPECT_NEAR(tick.torque.y(), torsional * (low - tilt), 10 * torque_error);
    EXPECT_LT(tick.force.head<2>().norm(), force_error);
}

/// A box on its corner: one vertex bears all of it, and the torque is that of its arm.
TEST(ToolOnPlane, OnItsCornerItTurnsUntilTheSpringsBalance)
{
    ToolBench bench = box_on_table();
    const Vec3 axis = Vec3(1, -1, 0).normalized();
    const double upright = std::acos(1 / std::sqrt(3.0)); // a diagonal points down
    bench.start(pose_at({0, 0, 0.03}, upright * axis));
    const ToolTick& tick =
        bench.lead(pose_at({0, 0, half * std::sqrt(3.0) - 0.002}, upright * axis), 100, 200);
    EXPECT_NEAR(tick.force.z(), stiffness * (0.002 + clearance), 10 * force_error);
    EXPECT_LT(tick.torque.norm(), 10 * torque_error); // the diagonal passes through the origin
    EXPECT_EQ(tick.contact_count, 1U);
}

/// Two edges that cross at right angles, and the tool above its own edge: the one contact bears all.
TEST(ToolOnEdge, CrossedEdgesTouchAtOnePoint)
{
    // A ridge along y with its edge at z = 0.
    const TriangleMesh ridge = mesh_of({{0, -0.1, 0},
                                        {0, 0.1, 0},
                                        {0.1, -0.1, -0.1},
                                        {0.1, 0.1, -0.1},
                                        {-0.1, -0.1, -0.1},
                                        {-0.1, 0.1, -0.1}},
                                       {{0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4}});
    ToolBench bench(box_mesh(Vec3::Constant(half)), {{index_of(ridge), {}}});
    const Vec3 turn(std::numbers::pi / 4, 0, 0); // an edge along x points down
    bench.start(pose_at({0, 0.004, 0.03}, turn));
    const double rest = half * std::numbers::sqrt2;
    const ToolTick& tick = bench.lead(pose_at({0, 0.004, rest - 0.003}, turn), 100, 100);
    EXPECT_NEAR(tick.force.z(), stiffness * (0.003 + clearance), force_error);
    EXPECT_LT(tick.force.head<2>().norm(), force_error);
    EXPECT_LT(tick.torque.norm(), torque_error);
    ASSERT_GE(tick.contact_count, 1U);
    EXPECT_LT((tick.contacts[0].position - Vec3(0, 0.004, 0)).norm(), 1e-6);
    EXPECT_FALSE(bench.meets());
}

/// Edges between triangles of one plane hold nothing back.
TEST(ToolOnPlane, ItSlidesOverTriangulatedPlanesWithoutCatching)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    const std::uint32_t cells = 24;
    for (std::uint32_t i = 0; i <= cells; ++i) {
        for (std::uint32_t k = 0; k <= cells; ++k)
            positions.emplace_back(0.1 * i / cells - 0.05, 0.1 * k / cells - 0.05, 0);
    }
    for (std::uint32_t i = 0; i < cells; ++i) {
        for (std::uint32_t k = 0; k < cells; ++k) {
            const std::uint32_t a = i * (cells + 1) + k;
            triangles.push_back({a, a + cells + 1, a + cells + 2});
            triangles.push_back({a, a + cells + 2, a + 1});
        }
    }
    const MeshIndex plane = index_of(mesh_of(positions, triangles));
    for (const double tilt : {0.0, 0.7}) {
        ToolBench bench(box_mesh(Vec3::Constant(half)), {{plane, {}}});
        const auto at = [&](double x) {
            return pose_at({x, 0.3 * x, tilt > 0 ? 0.012 : 0.008}, {tilt, 0, 0});
        };
        bench.start(pose_at({-0.03, -0.009, 0.03}, {tilt, 0, 0}));
        (void)bench.lead(at(-0.03), 50);
        for (int i = 0; i < 300; ++i) {
            const ToolTick& tick = bench.tick(at(-0.03 + 2e-4 * i));
            ASSERT_GT(tick.force.z(), 0.5);
            // Once over the way, not a sideways force of a hundredth of a millimetre's stretch.
            ASSERT_LT(tick.force.head<2>().norm(), stiffness * 1e-5) << i << ", tilt " << tilt;
        }
    }
}

/// Two slopes of 45 degrees: the ball rests on both, and each bears F / sqrt(2).
TEST(ToolInGroove, TheBallRestsOnBothSides)
{
    const double radius = 0.01;
    const TriangleMesh ball =
        moved(*sample_mesh("icosphere:3"), [&](const Vec3& p) { return Vec3(radius * p); });
    const TriangleMesh groove = groove_mesh();
    ToolBench bench(ball, {{index_of(groove), {}}});
    bench.start(pose_at({0.004, 0, 0.04}));
    const double depth = 0.003;
    const double device = radius * std::numbers::sqrt2 - depth;
    const ToolTick& tick = bench.lead(pose_at({0, 0.001, device}), 100, 200);
    // The facets of the ball are between these radii.
    const double least = radius * 0.985;
    EXPECT_GT(tick.proxy.translation.z(), (least + clearance) * std::numbers::sqrt2);
    EXPECT_LT(tick.proxy.translation.z(), (radius + clearance) * std::numbers::sqrt2 + settled);
    EXPECT_NEAR(tick.force.z(), stiffness * (tick.proxy.translation.z() - device), force_error);
    double right = 0;
    double left = 0;
    for (std::size_t i = 0; i < tick.contact_count; ++i) {
        const ToolContact& each = tick.contacts[i];
        (each.normal.x() < 0 ? right : left) += each.force;
        EXPECT_NEAR(std::abs(each.normal.x()), std::numbers::sqrt2 / 2, 1e-9);
    }
    // A ball of facets may turn a little and lie off the middle by what they are off a sphere.
    const double share = tick.force.z() / std::numbers::sqrt2;
    EXPECT_NEAR(right + left, 2 * share, 1e-6 * share);
    EXPECT_NEAR(right, left, stiffness * (radius - least) * std::numbers::sqrt2);
}

/// A square peg in a square hole with `play` on each side.
class ToolPegInHole : public ::testing::Test {
protected:
    static constexpr double play = 0.0005;
    static constexpr double side = 0.005;

    ToolPegInHole()
        : bench(box_mesh({side, side, 0.015}), {{index_of(block_with_hole(side, play, 0)), {}}})
    {
        bench.start(pose_at({0, 0, 0.02}));
    }
    ToolBench bench;
};

TEST_F(ToolPegInHole, ItSlidesInAndFeelsTheWallsByTheStretchBeyondThePlay)
{
    const ToolTick& in = bench.lead(pose_at({0, 0, -0.01}), 200);
    EXPECT_EQ(in.force, Vec3(Vec3::Zero()));
    const ToolTick& tick = bench.lead(pose_at({0.003, 0, -0.01}), 50);
    EXPECT_NEAR(tick.force.x(), -stiffness * (0.003 - play + clearance), force_error);
    EXPECT_LT(std::abs(tick.force.y()) + std::abs(tick.force.z()), force_error);
    EXPECT_LT(tick.torque.norm(), torque_error);
    EXPECT_FALSE(bench.meets());
    // Both ways at once, into the corner.
    const ToolTick& corner = bench.lead(pose_at({0.003, -0.002, -0.01}), 50);
    EXPECT_NEAR(corner.force.x(), -stiffness * (0.003 - play + clearance), force_error);
    EXPECT_NEAR(corner.force.y(), stiffness * (0.002 - play + clearance), force_error);
}

TEST_F(ToolPegInHole, TurnedAboutItsAxisItStopsAtTheAngleOfThePlay)
{
    (void)bench.lead(pose_at({0, 0, -0.01}), 200);
    const double turn = 0.4;
    const ToolTick& tick = bench.lead(pose_at({0, 0, -0.01}, {0, 0, turn}), 100);
    // A corner at side sqrt(2) reaches the wall: side (cos a + sin a) = side + play - clearance.
    const double room = side + play - clearance;
    const double most = std::asin(room / (side * std::numbers::sqrt2)) - std::numbers::pi / 4;
    EXPECT_NEAR(tick.torque.z(), -torsional * (turn - most), torsional * settled / side);
    EXPECT_LT(tick.force.norm(), force_error);
}

TEST_F(ToolPegInHole, ItCannotLeaveThroughTheWall)
{
    (void)bench.lead(pose_at({0, 0, -0.01}), 200);
    const ToolTick& tick = bench.lead(pose_at({0.2, 0.1, -0.01}, {0.3, 0.2, 0.1}), 400);
    EXPECT_LT(tick.proxy.translation.head<2>().cwiseAbs().maxCoeff(), 0.01);
    EXPECT_GT(tick.force.norm(), 50);
    EXPECT_FALSE(bench.meets());
    // It comes out again the way it went in.
    (void)bench.lead(pose_at({0, 0, -0.01}), 200);
    const ToolTick& out = bench.lead(pose_at({0, 0, 0.03}), 200);
    EXPECT_EQ(out.force, Vec3(Vec3::Zero()));
}

} // namespace
} // namespace proxima::testing::tool_statics_test
