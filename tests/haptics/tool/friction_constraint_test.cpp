#include "haptics/tool/friction_constraint.h"

#include "proxima/geometry.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <iostream>
#include <random>
#include <vector>

namespace proxima::testing::friction_constraint_test {
namespace {

constexpr double tolerance = 1e-6;

class RandomMotions {
public:
    explicit RandomMotions(std::uint32_t seed) : random_(seed) {}
    double unit() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
    Vec6 vector()
    {
        Vec6 v;
        for (int i = 0; i < 6; ++i) v[i] = unit();
        return v;
    }
    std::size_t below(std::size_t count) { return random_() % count; }
    Vec3 direction()
    {
        while (true) {
            const Vec3 v(unit(), unit(), unit());
            if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
        }
    }

private:
    std::mt19937 random_;
};

/// A body on points: their normals hold it back, and friction along them.
struct ContactProblem {
    Vec6 wanted;
    std::vector<MotionConstraint> constraints;
    std::vector<MotionFriction> frictions;
};

ContactProblem random_problem(std::uint32_t seed)
{
    RandomMotions random(seed);
    ContactProblem problem;
    problem.wanted = random.vector();
    const std::size_t count = 1 + random.below(6);
    const Vec3 shared = random.direction();
    const bool is_flat = random.below(2) == 0;
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 normal = is_flat ? shared : random.direction();
        const Vec3 arm(random.unit(), random.unit(), random.unit());
        const auto row = [&](const Vec3& v) {
            Vec6 r;
            r << v, arm.cross(v);
            return r;
        };
        problem.constraints.push_back({row(normal), -std::abs(random.unit()) * 0.1});
        MotionFriction friction;
        const Vec3 side = normal.unitOrthogonal();
        friction.along.row(0) = row(side).transpose();
        friction.along.row(1) = row(normal.cross(side)).transpose();
        friction.carried = 0.3 * Eigen::Vector2d(random.unit(), random.unit());
        friction.limit = random.below(5) == 0 ? 0 : std::pow(10, 2 * random.unit()) * 0.1;
        problem.frictions.push_back(friction);
    }
    return problem;
}

FrictionalMotion solve(const ContactProblem& problem)
{
    std::vector<MotionConstraint> scratch(problem.constraints.size());
    return least_constraint_with_friction(problem.wanted, problem.constraints, problem.frictions,
                                          tolerance, scratch);
}

/// Against the conditions that only the solution satisfies: forces balance, no contact pulls, friction
/// is within its limit, and has it against the motion where the contact slides.
TEST(FrictionConstraint, ForcesBalanceAndFrictionOpposesTheMotion)
{
    int sliding = 0;
    int sticking = 0;
    std::size_t most_steps = 0;
    double steps = 0;
    constexpr std::uint32_t problems = 2000;
    for (std::uint32_t seed = 1; seed <= problems; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const ContactProblem problem = random_problem(seed);
        const FrictionalMotion found = solve(problem);
        const ConstrainedMotion& motion = found.constrained;
        ASSERT_TRUE(motion.solved);
        most_steps = std::max(most_steps, found.steps);
        steps += static_cast<double>(found.steps) / problems;
        Vec6 sum = problem.wanted - motion.motion;
        for (std::size_t k = 0; k < motion.active_count; ++k) {
            const MotionConstraint& each = problem.constraints[motion.active[k]];
            EXPECT_GE(motion.pressure[k], 0);
            EXPECT_NEAR(each.direction.dot(motion.motion), each.bound, 2 * tolerance);
            sum += motion.pressure[k] * each.direction;
        }
        for (const MotionConstraint& each : problem.constraints)
            EXPECT_GE(each.direction.dot(motion.motion), each.bound - 2 * tolerance);
        for (std::size_t k = 0; k < problem.frictions.size(); ++k) {
            const MotionFriction& each = problem.frictions[k];
            sum -= each.along.transpose() * found.friction[k];
            const Eigen::Vector2d slid = each.slid(motion.motion);
            EXPECT_LE(found.friction[k].norm(), each.limit * (1 + 1e-9));
            // The power of friction at its limit is limit times speed: it points along the motion.
            // A contact that sticks slides by millionths of what is wanted.
            EXPECT_NEAR(found.friction[k].dot(slid), each.limit * slid.norm(), each.limit * 5e-6);
            if (each.limit > 0) ++(slid.norm() > tolerance ? sliding : sticking);
        }
        EXPECT_LT(sum.norm(), 1e-4);
    }
    std::cout << sliding << " contacts slide, " << sticking << " stick; " << steps
              << " steps in the mean, at most " << most_steps << "\n";
    EXPECT_GT(sliding, 1000);
    EXPECT_GT(sticking, 1000);
    EXPECT_LT(most_steps, 40U);
}

} // namespace
} // namespace proxima::testing::friction_constraint_test
