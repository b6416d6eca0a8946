#include "code_of.h"
#include "proxima/geometry.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace proxima::rigid_transform_test {
namespace {

using Numbers = std::array<double, 12>;

/// By Rodrigues' formula, apart from Eigen's.
Numbers turn_about(const Vec3& axis, double angle, const Vec3& translation)
{
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    Numbers numbers{};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            double r = (1 - c) * axis[row] * axis[column] + (row == column ? c : 0);
            if (column == (row + 1) % 3) r -= s * axis[(row + 2) % 3];
            if (row == (column + 1) % 3) r += s * axis[(column + 2) % 3];
            numbers[static_cast<std::size_t>(4 * row + column)] = r;
        }
        numbers[static_cast<std::size_t>(4 * row + 3)] = translation[row];
    }
    return numbers;
}

TEST(RigidTransform, MovesPointsThereAndBack)
{
    constexpr unsigned seed = 11;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-3, 3);
    for (int trial = 0; trial < 200; ++trial) {
        const auto any = [&] { return Vec3{number(random), number(random), number(random)}; };
        const Vec3 axis = any().normalized();
        const double angle = number(random);
        const Vec3 translation = any();
        const auto pose = make_rigid_transform(turn_about(axis, angle, translation));
        ASSERT_TRUE(pose) << describe(pose.error());
        const Vec3 p = any();
        const Vec3 expected = std::cos(angle) * p + std::sin(angle) * axis.cross(p) +
                              (1 - std::cos(angle)) * axis.dot(p) * axis + translation;
        EXPECT_LT(((*pose)(p)-expected).norm(), 1e-14);
        EXPECT_LT((pose->inverse()((*pose)(p)) - p).norm(), 1e-14);
        const Triangle moved = (*pose)(Triangle{{p, axis, translation}});
        EXPECT_EQ(moved[0], (*pose)(p));
        EXPECT_EQ(moved[1], (*pose)(axis));
        EXPECT_EQ(moved[2], (*pose)(translation));
    }
}

TEST(RigidTransform, RefusesWhatIsNotRigid)
{
    const Numbers good = turn_about(Vec3::UnitZ(), 0.5, Vec3(1, 2, 3));
    const auto refuses = [](const Numbers& numbers, const char* what) {
        const auto pose = make_rigid_transform(numbers);
        ASSERT_FALSE(pose) << what;
        EXPECT_EQ(code_of(pose), ErrorCode::invalid_argument);
        EXPECT_NE(pose.error().message.find(what), std::string::npos) << pose.error().message;
    };
    Numbers bad = good;
    bad[6] = std::numeric_limits<double>::quiet_NaN();
    refuses(bad, "row 1, column 2");
    bad = good;
    bad[3] = std::numeric_limits<double>::infinity();
    refuses(bad, "row 0, column 3");
    bad = good;
    bad[0] += 1e-2;
    refuses(bad, "stretches");
    bad = good;
    bad[0] = 1e200;
    refuses(bad, "stretches");
    bad = good;
    for (const std::size_t i : {2U, 6U, 10U}) bad[i] = -bad[i];
    refuses(bad, "mirrors");
    refuses({}, "scales by 0");
    bad = good;
    for (const std::size_t i : {0U, 1U, 2U, 4U, 5U, 6U, 8U, 9U, 10U}) bad[i] *= 1000;
    refuses(bad, "scales by 1000");
}

TEST(RigidTransform, TakesTheNearestRotationOfRoundedOnes)
{
    constexpr unsigned seed = 12;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-3, 3);
    for (int trial = 0; trial < 200; ++trial) {
        const Vec3 axis = Vec3{number(random), number(random), number(random)}.normalized();
        const Numbers exact = turn_about(axis, number(random), Vec3(1, 2, 3));
        Numbers off = exact;
        const double step = std::pow(10, -4 - trial % 12);
        for (double& x : off) x = std::round(x / step) * step;
        const auto pose = make_rigid_transform(off);
        ASSERT_TRUE(pose) << describe(pose.error());
        const auto given = make_rigid_transform(exact);
        // Half a step in nine numbers; what is taken as it is may be as far from a rotation.
        EXPECT_LT((pose->rotation - given->rotation).norm(), 2 * step);
        EXPECT_LE(rotation_error(off), 4 * step);
        const Mat3 product = pose->rotation.transpose() * pose->rotation;
        EXPECT_LE((product - Mat3::Identity()).norm(),
                  rotation_error(off) <= rigid_tolerance ? rigid_tolerance : 4e-15);
        // No rotation is nearer: polar decomposition against small turns of its own.
        if (rotation_error(off) <= rigid_tolerance) {
            EXPECT_EQ(pose->rotation(0, 0), off[0]);
            continue;
        }
        Mat3 matrix;
        for (int i = 0; i < 9; ++i)
            matrix(i / 3, i % 3) = off[static_cast<std::size_t>(4 * (i / 3) + i % 3)];
        for (int i = 0; i < 6; ++i) {
            const Vec3 about = (i % 2 == 0 ? 1 : -1) * Vec3::Unit(i / 2);
            const Mat3 turned =
                Eigen::AngleAxisd(step / 4, about).toRotationMatrix() * pose->rotation;
            EXPECT_LE((matrix - pose->rotation).norm(), (matrix - turned).norm());
        }
    }
}

} // namespace
} // namespace proxima::rigid_transform_test
