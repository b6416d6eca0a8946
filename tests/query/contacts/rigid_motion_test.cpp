#include "proxima/time_of_contact.h"

#include "query/contacts/random_motions.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace proxima::rigid_motion_test {
namespace {

using namespace testing;

TEST(RigidMotion, EndsAtItsPoses)
{
    std::mt19937_64 random(11);
    for (int i = 0; i < 200; ++i) {
        const RigidTransform from = random_pose(random, Vec3(1, 2, 3));
        const RigidTransform to = i % 5 == 0 ? from : random_pose(random, Vec3(-3, 0, 1));
        const Vec3 center(0.5, -1, 2);
        const RigidMotion motion = motion_between(from, to, center);
        EXPECT_LE(motion.turn.norm(), std::numbers::pi * (1 + 1e-15));
        const RigidTransform start = pose_at(motion, 0);
        EXPECT_EQ(start.rotation, from.rotation);
        EXPECT_EQ(start.translation, from.translation);
        const RigidTransform end = pose_at(motion, 1);
        EXPECT_LT((end.rotation - to.rotation).norm(), 1e-14);
        EXPECT_LT((end.translation - to.translation).norm(), 1e-13);
        const Vec3 middle = pose_at(motion, 0.5)(center);
        EXPECT_LT((middle - 0.5 * (from(center) + to(center))).norm(), 1e-14);
    }
}

TEST(RigidMotion, IsCheckedForNumbers)
{
    EXPECT_TRUE(check_motion({}));
    EXPECT_TRUE(check_motion({.turn = Vec3(max_motion_turn, 0, 0)}));
    for (const double bad : {HUGE_VAL, std::nan("")}) {
        for (int field = 0; field < 5; ++field) {
            RigidMotion motion;
            Vec3* const vectors[] = {&motion.center, &motion.displacement, &motion.turn,
                                     &motion.start.translation};
            if (field < 4) {
                (*vectors[field])[1] = bad;
            } else {
                motion.start.rotation(2, 1) = bad;
            }
            EXPECT_FALSE(check_motion(motion));
        }
    }
    EXPECT_FALSE(check_motion({.turn = Vec3(0, 70000, 0)}));
}

// In the box's middle, whose coordinates are of size 1, such a step would be lost.
TEST(RigidMotion, KeepsTheSmallestSteps)
{
    const RigidTransform from;
    const RigidTransform to{Mat3::Identity(), Vec3(0, 0, -1e-165)};
    EXPECT_EQ(motion_between(from, to, Vec3(0.5, -1, 2)).displacement, to.translation);
}

} // namespace
} // namespace proxima::rigid_motion_test
