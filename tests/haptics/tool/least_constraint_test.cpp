#include "haptics/tool/least_constraint.h"

#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace proxima::testing::least_constraint_test {
namespace {

/// Against the conditions that only the nearest motion satisfies (Karush, Kuhn and Tucker).
TEST(LeastConstraint, FindsTheNearestMotionThatAllConstraintsAllow)
{
    int active = 0;
    for (std::uint32_t seed = 1; seed <= 400; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
        const auto vector = [&] {
            Vec6 v;
            for (int i = 0; i < 6; ++i) v[i] = unit();
            return v;
        };
        std::vector<MotionConstraint> constraints(1 + random() % 40);
        for (MotionConstraint& each : constraints) each = {vector(), -std::abs(unit()) * 0.3};
        // Copies and sums of others, as contacts of one face are.
        for (std::size_t i = 1; i < constraints.size(); ++i) {
            if (random() % 4 == 0) constraints[i] = constraints[i - 1];
            if (random() % 4 == 0 && i > 1) {
                constraints[i].direction =
                    constraints[i - 1].direction + constraints[i - 2].direction;
                constraints[i].bound = constraints[i - 1].bound + constraints[i - 2].bound;
            }
        }
        const Vec6 wanted = 2 * vector();
        const ConstrainedMotion found = least_constraint(wanted, constraints, 1e-12);
        ASSERT_TRUE(found.solved);
        for (const MotionConstraint& each : constraints)
            EXPECT_GE(each.direction.dot(found.motion), each.bound - 1e-9);
        Vec6 pushed = Vec6::Zero();
        for (std::size_t k = 0; k < found.active_count; ++k) {
            const MotionConstraint& each = constraints[found.active[k]];
            EXPECT_GE(found.pressure[k], -1e-12);
            EXPECT_NEAR(each.direction.dot(found.motion), each.bound, 1e-9);
            pushed += found.pressure[k] * each.direction;
        }
        EXPECT_LT((found.motion - wanted - pushed).norm(), 1e-9);
        active += static_cast<int>(found.active_count);
    }
    EXPECT_GT(active, 800);
}

TEST(LeastConstraint, ConstraintsThatContradictEachOtherAreNotSolved)
{
    Vec6 up = Vec6::Zero();
    up[2] = 1;
    const std::vector<MotionConstraint> squeezed = {{up, 1}, {Vec6(-up), 1}};
    EXPECT_FALSE(least_constraint(Vec6::Zero(), squeezed, 1e-9).solved);
}

} // namespace
} // namespace proxima::testing::least_constraint_test
