// Tools at rest against closed forms: positions, forces and torques.
#include "haptics/tool/tool_bench.h"
#include "proxima/tool_renderer.h"

#include <gtest/gtest.h>

namespace proxima::testing {
namespace {

constexpr double clearance = 1e-5;
constexpr double half = 0.01; // of the box, m

TriangleMesh table()
{
    return box_mesh({0.1, 0.1, 0.05}, {0, 0, -0.05}); // its top is z = 0
}

TEST(ToolOnPlane, PushedDownItFeelsTheStretchAndNoTorque)
{
    ToolBench bench(box_mesh(Vec3::Constant(half)), {{index_of(table()), {}}});
    bench.start(pose_at({0.003, 0.002, 0.02}));
    const ToolTick& tick = bench.lead(pose_at({0.003, 0.002, half - 0.004}), 50);
    EXPECT_TRUE(tick.is_placed);
    EXPECT_NEAR(tick.force.z(), 500 * (0.004 + clearance), 500 * 1e-8);
    EXPECT_LT(tick.force.head<2>().norm(), 500 * 1e-8);
    EXPECT_LT(tick.torque.norm(), 0.5 * 1e-6);
    EXPECT_EQ(tick.end, ToolEnd::settled);
    EXPECT_FALSE(bench.meets());
}

} // namespace
} // namespace proxima::testing
