// The trajectory of an object of a scene to the pose that the application gave (ObjectMotion).
//
//     application   now and then        a pose, the time until then, and the velocity after it
//     servo loop    every millisecond   a pose in between: straight, turning evenly about one axis
#pragma once

#include "proxima/geometry.h"
#include "proxima/touch_scene.h"

namespace proxima {

/// The pose of an object, tick by tick. noexcept, no allocation, 0.2 us.
class ObjectTrajectory {
public:
    ObjectTrajectory() = default;
    explicit ObjectTrajectory(const RigidTransform& pose) noexcept;

    /// Begins a motion from the present pose.
    void follow(const ObjectMotion& motion) noexcept;

    /// Advances by a tick. \pre seconds > 0
    void advance(double seconds) noexcept;

    [[nodiscard]] const RigidTransform& before() const noexcept { return before_; }
    [[nodiscard]] const RigidTransform& now() const noexcept { return now_; }
    [[nodiscard]] bool moved() const noexcept { return moved_; } ///< in the last tick

private:
    ObjectMotion motion_;
    RigidTransform from_;
    Vec3 turn_ = Vec3::Zero(); ///< rotation from `from_` to the pose: axis times angle
    double passed_ = 0;        ///< s since the motion began
    bool resting_ = true;
    bool moved_ = false;
    RigidTransform before_;
    RigidTransform now_;
};

/// A position of the scene in the frame of an object with this pose, rounded a few times.
[[nodiscard]] inline Vec3 to_local(const RigidTransform& pose, const Vec3& p) noexcept
{
    return pose.rotation.transpose() * (p - pose.translation);
}

/// The pose with its rotation made orthonormal to rounding. \pre it is rigid to rigid_tolerance
[[nodiscard]] RigidTransform orthonormalized(const RigidTransform& pose) noexcept;

} // namespace proxima
