#include "proxima/time_of_contact.h"

#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "query/contacts/child_steps.h"
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

TEST(RigidMotion, StepsOfBlocksDoNotDependOnTheSignOfTheHint)
{
    const MeshIndex ball = build_mesh_index(make_icosphere(1)).value();
    int by_hint = 0;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        const RigidMotion motion = {.start = random_pose(random, 4 * random_direction(random)),
                                    .displacement = 3 * random_direction(random),
                                    .turn = random_direction(random)};
        const MotionBounds bounds(ball.parts(), ball.parts(), motion);
        const MovedFrame frame = bounds.frame_at(0);
        const BoundedBlock a = {.center = bounds.center_a(), .half = Vec3::Constant(0.1)};
        const BoundedBlock b = {.center = frame.origin, .half = Vec3::Constant(0.1)};
        const Vec3 hint = random_direction(random);
        ChildSteps steps[2];
        for (const bool is_turned : {false, true}) {
            find_child_steps(bounds,
                             {.frame = frame,
                              .a = a,
                              .b = b,
                              .node = nullptr,
                              .opens_a = false,
                              .hint = is_turned ? Vec3(-hint) : hint,
                              .within = 1,
                              .enough = 1e-9},
                             steps[is_turned ? 1 : 0]);
        }
        EXPECT_GT(steps[0].step[0], 0);
        EXPECT_EQ(steps[0].step[0], steps[1].step[0]);
        EXPECT_EQ(steps[0].direction_of(0), steps[1].direction_of(0));
        if (std::abs(steps[0].direction_of(0).dot(hint)) > 1 - 1e-12) ++by_hint;
    }
    EXPECT_GT(by_hint, 100);
}

} // namespace
} // namespace proxima::rigid_motion_test
