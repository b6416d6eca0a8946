#include "haptics/scene/object_trajectory.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace proxima {
namespace {

constexpr double tick_seconds = 1e-3;

RigidTransform turned(double angle, const Vec3& axis, const Vec3& to)
{
    return {Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), to};
}

TEST(ObjectTrajectory, MovesEvenlyAndArrives)
{
    ObjectTrajectory course(turned(0.3, Vec3(1, 2, 3), Vec3(1, 0, 0)));
    const RigidTransform goal = turned(-0.9, Vec3(2, -1, 1), Vec3(2, 3, -1));
    course.follow({.pose = goal, .seconds = 0.02});
    const Vec3 step = (goal.translation - course.now().translation) / 20;
    double angle = -1;
    for (int tick = 0; tick < 20; ++tick) {
        course.advance(tick_seconds);
        EXPECT_TRUE(course.moved());
        const Vec3 way = course.now().translation - course.before().translation;
        EXPECT_LT((way - step).norm(), 1e-12) << tick;
        const Mat3 turn = course.now().rotation * course.before().rotation.transpose();
        const double by = Eigen::AngleAxisd(turn).angle();
        if (angle >= 0) {
            EXPECT_NEAR(by, angle, 1e-9) << tick;
        }
        angle = by;
        EXPECT_LT(
            (course.now().rotation.transpose() * course.now().rotation - Mat3::Identity()).norm(),
            1e-14);
    }
    EXPECT_GT(angle, 0.01);
    EXPECT_EQ(course.now().translation, goal.translation);
    EXPECT_LT((course.now().rotation - goal.rotation).norm(), 1e-15);
    course.advance(tick_seconds);
    EXPECT_FALSE(course.moved()); // it stands there
}

TEST(ObjectTrajectory, CoastsForItsCoastingTime)
{
    ObjectTrajectory course(RigidTransform{});
    course.follow({.velocity = Vec3(2, 0, 0), .spin = Vec3(0, 0, 5), .coast_seconds = 0.05});
    course.advance(tick_seconds); // in the next tick it is at the pose
    EXPECT_EQ(course.now().translation, Vec3::Zero());
    for (int tick = 1; tick <= 50; ++tick) {
        course.advance(tick_seconds);
        EXPECT_NEAR(course.now().translation.x(), 0.002 * tick, 1e-12);
        EXPECT_NEAR(course.now().rotation(1, 0), std::sin(0.005 * tick), 1e-12);
    }
    for (int tick = 0; tick < 5; ++tick) course.advance(tick_seconds);
    EXPECT_NEAR(course.now().translation.x(), 0.1, 1e-12);
    EXPECT_FALSE(course.moved());
}

TEST(ObjectTrajectory, StartsANewMotionFromWhereItIs)
{
    ObjectTrajectory course(RigidTransform{});
    course.follow({.pose = {Mat3::Identity(), Vec3(1, 0, 0)}, .seconds = 0.02});
    for (int tick = 0; tick < 10; ++tick) course.advance(tick_seconds);
    const Vec3 at = course.now().translation;
    EXPECT_NEAR(at.x(), 0.5, 1e-12);
    course.follow({.pose = {Mat3::Identity(), Vec3(0, 1, 0)}, .seconds = 0.01});
    course.advance(tick_seconds);
    EXPECT_LT((course.now().translation - (at + (Vec3(0, 1, 0) - at) / 10)).norm(), 1e-12);
}

} // namespace
} // namespace proxima
