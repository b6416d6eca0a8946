#include "haptics/scene/object_trajectory.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace proxima::object_motion_test {
namespace {

constexpr SceneTime tick_time = 1'000'000;

/// An object whose course is followed from a time on, tick by tick.
class Follower {
public:
    explicit Follower(const RigidTransform& pose) : course_(pose), trajectory_(course_, 0) {}

    void follow(const ObjectMotion& motion)
    {
        course_ = course_.continued(motion, time_);
        trajectory_.follow(course_);
    }
    void advance() { trajectory_.advance(time_ += tick_time); }
    [[nodiscard]] const RigidTransform& before() const { return trajectory_.before(); }
    [[nodiscard]] const RigidTransform& now() const { return trajectory_.now(); }
    [[nodiscard]] bool moved() const { return trajectory_.moved(); }

private:
    ObjectCourse course_;
    ObjectTrajectory trajectory_;
    SceneTime time_ = 0;
};

RigidTransform turned(double angle, const Vec3& axis, const Vec3& to)
{
    return {Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), to};
}

TEST(ObjectTrajectory, MovesEvenlyAndArrives)
{
    Follower course(turned(0.3, Vec3(1, 2, 3), Vec3(1, 0, 0)));
    const RigidTransform goal = turned(-0.9, Vec3(2, -1, 1), Vec3(2, 3, -1));
    course.follow({.pose = goal, .seconds = 0.02});
    const Vec3 step = (goal.translation - course.now().translation) / 20;
    double angle = -1;
    for (int tick = 0; tick < 20; ++tick) {
        course.advance();
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
    course.advance();
    EXPECT_FALSE(course.moved()); // it stands there
}

TEST(ObjectTrajectory, ItsPivotGoesStraight)
{
    const RigidTransform begin = turned(0.3, Vec3(1, 2, 3), Vec3(1, 0, 0));
    const RigidTransform goal = turned(-0.9, Vec3(2, -1, 1), Vec3(2, 3, -1));
    const Vec3 pivot(5, -7, 3);
    const ObjectCourse course = ObjectCourse(begin).continued({goal, 0.02}, 0, pivot);
    const Vec3 first = begin(pivot);
    for (int tick = 0; tick <= 20; ++tick) {
        const RigidTransform now = course.pose_at(tick * tick_time);
        const Vec3 at = first + tick / 20.0 * (goal(pivot) - first);
        EXPECT_LT((now(pivot) - at).norm(), 1e-13) << tick;
    }
    EXPECT_EQ(course.pose_at(20 * tick_time).translation, goal.translation);
}

TEST(ObjectTrajectory, CoastsForItsCoastingTime)
{
    Follower course(RigidTransform{});
    course.follow({.velocity = Vec3(2, 0, 0), .spin = Vec3(0, 0, 5), .coast_seconds = 0.05});
    for (int tick = 1; tick <= 50; ++tick) {
        course.advance();
        EXPECT_NEAR(course.now().translation.x(), 0.002 * tick, 1e-12);
        EXPECT_NEAR(course.now().rotation(1, 0), std::sin(0.005 * tick), 1e-12);
    }
    for (int tick = 0; tick < 5; ++tick) course.advance();
    EXPECT_NEAR(course.now().translation.x(), 0.1, 1e-12);
    EXPECT_FALSE(course.moved());
}

TEST(ObjectTrajectory, PosesDependOnTheTimeAlone)
{
    const ObjectCourse first(turned(0.3, Vec3(1, 2, 3), Vec3(1, 0, 0)));
    const ObjectCourse second = first.continued({.pose = turned(-2, Vec3(0, 1, 3), Vec3(0, 4, 1)),
                                                 .seconds = 0.01,
                                                 .velocity = Vec3(1, 2, 3),
                                                 .spin = Vec3(3, 1, 2),
                                                 .coast_seconds = 0.005},
                                                3 * tick_time);
    EXPECT_EQ(second.pose_at(2 * tick_time).translation, Vec3(1, 0, 0)); // a tool that lags behind
    ObjectTrajectory ticks(second, 3 * tick_time);
    ticks.follow(second);
    for (SceneTime time = 4 * tick_time; time < 25 * tick_time; time += tick_time) {
        ticks.advance(time);
        ObjectTrajectory late(first, 2 * tick_time);
        late.follow(second);
        late.advance(time);
        EXPECT_EQ(late.now().translation, ticks.now().translation) << time;
        EXPECT_EQ(late.now().rotation, ticks.now().rotation) << time;
    }
}

TEST(ObjectTrajectory, StartsANewMotionFromWhereItIs)
{
    Follower course(RigidTransform{});
    course.follow({.pose = {Mat3::Identity(), Vec3(1, 0, 0)}, .seconds = 0.02});
    for (int tick = 0; tick < 10; ++tick) course.advance();
    const Vec3 at = course.now().translation;
    EXPECT_NEAR(at.x(), 0.5, 1e-12);
    course.follow({.pose = {Mat3::Identity(), Vec3(0, 1, 0)}, .seconds = 0.01});
    course.advance();
    EXPECT_LT((course.now().translation - (at + (Vec3(0, 1, 0) - at) / 10)).norm(), 1e-12);
}

TEST(ObjectTrajectory, StartsAtRestWhereItsCourseIs)
{
    const RigidTransform pose = turned(0.3, Vec3(1, 2, 3), Vec3(1, 5, 0));
    const ObjectCourse course(pose);
    ObjectTrajectory trajectory(course, 0);
    trajectory.start(5 * tick_time);
    EXPECT_FALSE(trajectory.moved());
    EXPECT_EQ(trajectory.now().translation, pose.translation);
    trajectory.advance(6 * tick_time); // and no other course was given
    EXPECT_FALSE(trajectory.moved());
    EXPECT_EQ(trajectory.now().translation, pose.translation);
    // A motion that is half done, as if it had been there before.
    trajectory.follow(course.continued({.pose = {pose.rotation, Vec3(3, 5, 0)}, .seconds = 0.02},
                                       10 * tick_time));
    trajectory.start(20 * tick_time);
    EXPECT_FALSE(trajectory.moved());
    EXPECT_NEAR(trajectory.now().translation.x(), 2, 1e-12);
    EXPECT_EQ(trajectory.before().translation, trajectory.now().translation);
}

TEST(ObjectTrajectory, AMotionOfNoTimeIsForTheNextTick)
{
    const ObjectCourse course(turned(0.3, Vec3(1, 2, 3), Vec3(1, 0, 0)));
    const Vec3 goal(0, 7, 0);
    const ObjectCourse jump =
        course.continued({.pose = {Mat3::Identity(), goal}, .seconds = 0}, 3 * tick_time);
    EXPECT_EQ(jump.pose_at(3 * tick_time).translation, Vec3(1, 0, 0));
    EXPECT_FALSE(jump.rests_at(3 * tick_time));
    EXPECT_EQ(jump.pose_at(3 * tick_time + 1).translation, goal);
    EXPECT_TRUE(jump.rests_at(3 * tick_time + 1));
}

TEST(ObjectTrajectory, ArrivesABillionthOfItsTimeEarly)
{
    // Ticks are rounded to nanoseconds: the last one of a second may be that early.
    const RigidTransform goal = turned(0.5, Vec3(1, 2, 3), Vec3(1, 2, 3));
    const ObjectCourse course = ObjectCourse(RigidTransform{}).continued({goal, 1.0}, 0);
    constexpr SceneTime arrival = 999'999'999;
    EXPECT_FALSE(course.rests_at(arrival - 1));
    EXPECT_NE(course.pose_at(arrival - 1).translation, goal.translation);
    EXPECT_TRUE(course.rests_at(arrival));
    EXPECT_EQ(course.pose_at(arrival).translation, goal.translation);
}

TEST(ObjectTrajectory, SlidesAndTurnsAreMotions)
{
    Follower course(RigidTransform{});
    course.follow({.pose = {Mat3::Identity(), Vec3(1, 0, 0)}, .seconds = 0.002});
    course.advance();
    EXPECT_TRUE(course.moved());
    course.advance();
    EXPECT_TRUE(course.moved());
    course.advance();
    EXPECT_FALSE(course.moved());
    course.follow({.pose = turned(1, Vec3(0, 1, 0), Vec3(1, 0, 0)), .seconds = 0.002});
    course.advance();
    EXPECT_TRUE(course.moved());
}

// Each motion begins ahead of a tool that lags behind, and the next one comes before its time does.
TEST(ObjectTrajectory, AToolThatLagsBehindFollowsMotionsOfEveryTick)
{
    for (const int lag : {1, 3, 20}) {
        ObjectCourse course(RigidTransform{});
        ObjectTrajectory ahead(course, 0);
        ObjectTrajectory behind(course, 0);
        std::vector<Vec3> places = {Vec3::Zero()};
        for (int tick = 1; tick <= 100; ++tick) {
            const SceneTime time = tick * tick_time;
            course = course.continued(
                {.pose = {Mat3::Identity(), Vec3(tick, 0, 0)}, .seconds = 0.002}, time - tick_time);
            ahead.follow(course);
            ahead.advance(time);
            places.push_back(ahead.now().translation);
            behind.follow(course);
            if (tick < lag) continue;
            behind.advance(time - lag * tick_time);
            const Vec3& place = places[static_cast<std::size_t>(tick - lag)];
            if (lag <= 3) {
                EXPECT_EQ(behind.now().translation, place) << tick; // the same bits
            } else {
                // More motions than there is room for.
                EXPECT_GE(behind.now().translation.x(), place.x() - 20) << tick;
            }
        }
    }
}

} // namespace
} // namespace proxima::object_motion_test
