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

} // namespace

RigidTransform orthonormalized(const RigidTransform& pose) noexcept
{
    return {Eigen::Quaterniond(pose.rotation).normalized().toRotationMatrix(), pose.translation};
}

ObjectTrajectory::ObjectTrajectory(const RigidTransform& pose) noexcept
    : before_(orthonormalized(pose)), now_(before_)
{
    motion_.pose = now_;
}

void ObjectTrajectory::follow(const ObjectMotion& motion) noexcept
{
    motion_ = motion;
    motion_.pose = orthonormalized(motion.pose);
    from_ = now_;
    const Eigen::AngleAxisd turn(Mat3(motion_.pose.rotation * from_.rotation.transpose()));
    turn_ = turn.angle() * turn.axis();
    passed_ = 0;
    resting_ = false;
}

void ObjectTrajectory::advance(double seconds) noexcept
{
    before_ = now_;
    moved_ = false;
    if (resting_) return;
    passed_ += seconds;
    // The sum of ticks may be less than the wanted time by a few roundings.
    const double arrival = motion_.seconds * (1 - 1e-9);
    if (passed_ < arrival) {
        const double part = passed_ / motion_.seconds;
        now_.rotation = turned(turn_, part) * from_.rotation;
        now_.translation =
            from_.translation + part * (motion_.pose.translation - from_.translation);
    } else {
        const double since =
            motion_.seconds > 0 ? std::max(passed_ - motion_.seconds, 0.0) : passed_ - seconds;
        const double coasted = std::min(since, motion_.coast_seconds);
        now_.rotation = turned(motion_.spin, coasted) * motion_.pose.rotation;
        now_.translation = motion_.pose.translation + coasted * motion_.velocity;
        const bool stands = motion_.velocity.isZero(0) && motion_.spin.isZero(0);
        resting_ = stands || since >= motion_.coast_seconds;
    }
    moved_ = now_.rotation != before_.rotation || now_.translation != before_.translation;
}

} // namespace proxima
