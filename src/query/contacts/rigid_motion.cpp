#include "base/text.h"
#include "geometry/length.h"
#include "proxima/time_of_contact.h"

#include <cmath>

namespace proxima {

RigidTransform pose_at(const RigidMotion& motion, double time) noexcept
{
    if (time == 0) return motion.start;
    RigidTransform pose = motion.start;
    const double angle = length_of(motion.turn);
    if (angle == 0) {
        pose.translation += time * motion.displacement;
        return pose;
    }
    const Eigen::AngleAxisd turned(time * angle, motion.turn / angle);
    pose.rotation = turned.toRotationMatrix() * motion.start.rotation;
    const Vec3 center = motion.start(motion.center) + time * motion.displacement;
    pose.translation = center - pose.rotation * motion.center;
    return pose;
}

RigidMotion motion_between(const RigidTransform& from, const RigidTransform& to,
                           const Vec3& center) noexcept
{
    RigidMotion motion = {.start = from, .center = center};
    if (from.rotation == to.rotation) { // nor is what is small beside the center lost
        motion.displacement = to.translation - from.translation;
        return motion;
    }
    motion.displacement = to(center) - from(center);
    const Mat3 turned = to.rotation * from.rotation.transpose();
    // Of the quaternion and its negative, the one that turns by half a revolution at most.
    Eigen::Quaterniond quaternion(turned);
    if (quaternion.w() < 0) quaternion.coeffs() *= -1;
    const double sine = length_of(quaternion.vec());
    if (sine > 0) motion.turn = 2 * std::atan2(sine, quaternion.w()) / sine * quaternion.vec();
    return motion;
}

Status check_motion(const RigidMotion& motion)
{
    const bool finite = motion.start.rotation.allFinite() && motion.start.translation.allFinite() &&
                        motion.center.allFinite() && motion.displacement.allFinite() &&
                        motion.turn.allFinite();
    if (!finite) {
        return fail(ErrorCode::invalid_argument,
                    "a number of the motion is NaN or infinite: give finite ones");
    }
    const double angle = length_of(motion.turn);
    if (angle <= max_motion_turn) return {};
    return fail(ErrorCode::invalid_argument,
                concat("the motion turns by ", angle, " radians, and at most ", max_motion_turn,
                       " are possible: divide it into several"));
}

} // namespace proxima
