// How scenes move rays, planes and poses into the frame of an instance, against what its pose does to points. All numbers
// are few bits and rotations take axes to axes, so that everything is exact.
#include "proxima/scene.h"
#include "query/scene/random_scenes.h"

#include <cmath>
#include <gtest/gtest.h>

namespace proxima::instance_frames_test {
namespace {

using namespace testing;

/// The rotations that take axes to axes, four quarter turns about each of six.
std::vector<Mat3> axis_rotations()
{
    std::vector<Mat3> found;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            if (i == j) continue;
            for (int signs = 0; signs < 4; ++signs) {
                Mat3 turn;
                turn.col(0) = (signs & 1) == 0 ? Vec3::Unit(i) : Vec3(-Vec3::Unit(i));
                turn.col(1) = (signs & 2) == 0 ? Vec3::Unit(j) : Vec3(-Vec3::Unit(j));
                turn.col(2) = turn.col(0).cross(turn.col(1));
                found.push_back(turn);
            }
        }
    }
    return found;
}

/// Multiples of 1/8 up to 100.
Vec3 few_bits(SceneGenerator& random)
{
    return (800 * random.vector()).array().round() / 8;
}

TEST(Scene, MovesIntoFramesOfInstancesWhatPosesMoveOutOfThem)
{
    constexpr std::uint64_t seed = 14;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    SceneGenerator random(seed);
    const std::vector<Mat3> rotations = axis_rotations();
    ASSERT_EQ(rotations.size(), 24U);
    for (const Mat3& rotation : rotations) {
        const RigidTransform a = {rotation, few_bits(random)};
        const RigidTransform b = {rotations[random.below(24)], few_bits(random)};
        const Vec3 p = few_bits(random);
        EXPECT_EQ(instance_frame(a)(a(p)), p);
        EXPECT_EQ(a(relative_pose(a, b)(p)), b(p));
        const Ray ray = {few_bits(random), few_bits(random), -1.5, 2.5};
        const Ray own = to_instance(a, ray);
        EXPECT_EQ(a(own.origin), ray.origin);
        EXPECT_EQ(a.rotation * own.direction, ray.direction);
        EXPECT_EQ(own.t_min, ray.t_min);
        EXPECT_EQ(own.t_max, ray.t_max);
        const ViewPlane plane = {few_bits(random), few_bits(random)[0]};
        const ViewPlane moved = to_instance(a, plane);
        EXPECT_EQ(moved.normal.dot(p) + moved.offset, plane.normal.dot(a(p)) + plane.offset);
    }
}

} // namespace
} // namespace proxima::instance_frames_test
