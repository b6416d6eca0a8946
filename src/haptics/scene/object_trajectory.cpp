#include "haptics/scene/object_trajectory.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace proxima {

namespace {

Mat3 turned(const Vec3& turn, double part) noexcept
{
    const double angle = turn.norm() * part;
    if (!(std::abs(angle) > 0)) return Mat3::Identity();
    return Eigen::AngleAxisd(angle, turn.normalized()).toRotationMatrix();
}

RigidTransform orthonormalized(const RigidTransform& pose) noexcept
{
    return {Eigen::Quaterniond(pose.rotation).normalized().toRotationMatrix(), pose.translation};
}

} // namespace

RigidTransform coasted(const ObjectMotion& motion, double seconds) noexcept
{
    return {turned(motion.spin, seconds) * motion.pose.rotation,
            motion.pose.translation + seconds * motion.velocity};
}

ObjectCourse::ObjectCourse(const RigidTransform& pose) noexcept : from_(orthonormalized(pose))
{
    motion_.pose = from_;
}

ObjectCourse ObjectCourse::continued(const ObjectMotion& motion, SceneTime start,
                                     const Vec3& pivot) const noexcept
{
    ObjectCourse next;
    next.motion_ = motion;
    next.motion_.pose = orthonormalized(motion.pose);
    next.from_ = pose_at(start);
    next.pivot_ = pivot;
    const Eigen::AngleAxisd turn(
        Mat3(next.motion_.pose.rotation * next.from_.rotation.transpose()));
    next.turn_ = turn.angle() * turn.axis();
    next.start_ = start;
    return next;
}

RigidTransform ObjectCourse::pose_at(SceneTime time) const noexcept
{
    if (time <= start_) return from_;
    const double passed = seconds_between(start_, time);
    if (passed < arrival()) {
        const double part = passed / motion_.seconds;
        const Mat3 rotation = turned(turn_, part) * from_.rotation;
        const Vec3 begin = from_(pivot_);
        return {rotation, begin + part * (motion_.pose(pivot_) - begin) - rotation * pivot_};
    }
    const double since = std::max(passed - motion_.seconds, 0.0);
    return coasted(motion_, std::min(since, motion_.coast_seconds));
}

bool ObjectCourse::rests_at(SceneTime time) const noexcept
{
    const double passed = seconds_between(start_, time);
    if (time <= start_ || passed < arrival()) return false;
    const bool stands = motion_.velocity.isZero(0) && motion_.spin.isZero(0);
    return stands || passed - motion_.seconds >= motion_.coast_seconds;
}

ObjectTrajectory::ObjectTrajectory(const ObjectCourse& course, SceneTime time) noexcept
    : course_(course), resting_(course.rests_at(time)), before_(course.pose_at(time)), now_(before_)
{}

void ObjectTrajectory::follow(const ObjectCourse& course) noexcept
{
    if (waiting_count_ == waiting_.size()) --waiting_count_;
    waiting_[waiting_count_++] = course;
}

void ObjectTrajectory::start(SceneTime time) noexcept
{
    if (waiting_count_ > 0) course_ = waiting_[waiting_count_ - 1];
    waiting_count_ = 0;
    resting_ = course_.rests_at(time);
    moved_ = false;
    before_ = now_ = course_.pose_at(time);
}

void ObjectTrajectory::advance(SceneTime time) noexcept
{
    before_ = now_;
    moved_ = false;
    std::size_t begun = 0;
    while (begun < waiting_count_ && time >= waiting_[begun].start()) ++begun;
    if (begun > 0) {
        course_ = waiting_[begun - 1];
        std::move(waiting_.begin() + begun, waiting_.begin() + waiting_count_, waiting_.begin());
        waiting_count_ -= begun;
        resting_ = false;
    }
    if (resting_) return;
    now_ = course_.pose_at(time);
    resting_ = course_.rests_at(time);
    moved_ = now_.rotation != before_.rotation || now_.translation != before_.translation;
}

} // namespace proxima
