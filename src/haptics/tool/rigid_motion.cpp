#include "haptics/tool/rigid_motion.h"

#include "geometry/length.h"

#include <Eigen/Geometry>
#include <cmath>

namespace proxima {

Vec3 rotation_vector(const Mat3& rotation) noexcept
{
    Eigen::Quaterniond q(rotation);
    q.normalize();
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const double sine = q.vec().norm();
    // atan2 is linear here: the ratio tends to 2.
    if (!(sine > 1e-150)) return Vec3::Zero();
    return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

Twist twist_between(const RigidTransform& from, const RigidTransform& to) noexcept
{
    // The product of equal rotations is not exactly the identity.
    if (from.rotation == to.rotation) return {to.translation - from.translation, Vec3::Zero()};
    return {to.translation - from.translation,
            rotation_vector(to.rotation * from.rotation.transpose())};
}

RigidTransform moved_by(const RigidTransform& pose, const Twist& twist, double t) noexcept
{
    RigidTransform result = {pose.rotation, pose.translation + t * twist.linear};
    const double angle = t * twist.angular.norm();
    if (angle > 0) {
        const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, unit_of(twist.angular)));
        result.rotation =
            (turn * Eigen::Quaterniond(pose.rotation)).normalized().toRotationMatrix();
    }
    return result;
}

} // namespace proxima
