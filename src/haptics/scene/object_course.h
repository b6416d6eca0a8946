// How an object of a scene goes from where it is to where the application says (ObjectMotion).
//
//     application   now and then        "in 20 ms it is there; then it goes on at this velocity"
//     servo loop    every millisecond   a place on the way: straight, turning evenly about one axis
#pragma once

#include "proxima/geometry.h"
#include "proxima/touch_scene.h"

namespace proxima {

/// Where an object is, tick by tick. noexcept, no allocation, 0.2 us.
class ObjectCourse {
public:
    ObjectCourse() = default;
    explicit ObjectCourse(const RigidTransform& pose) noexcept;

    /// From where it is now on.
    void follow(const ObjectMotion& motion) noexcept;

    /// One tick on. \pre seconds > 0
    void advance(double seconds) noexcept;

    [[nodiscard]] const RigidTransform& before() const noexcept { return before_; }
    [[nodiscard]] const RigidTransform& now() const noexcept { return now_; }
    [[nodiscard]] bool moved() const noexcept { return moved_; } ///< in the last tick

private:
    ObjectMotion motion_;
    RigidTransform from_;
    Vec3 turn_ = Vec3::Zero(); ///< from `from_` to the pose: an axis as long as the angle
    double passed_ = 0;        ///< since the word
    bool resting_ = true;
    bool moved_ = false;
    RigidTransform before_;
    RigidTransform now_;
};

/// A place of the scene as the object at this pose sees it, rounded a few times.
[[nodiscard]] inline Vec3 seen_from(const RigidTransform& pose, const Vec3& p) noexcept
{
    return pose.rotation.transpose() * (p - pose.translation);
}

/// The pose with its rotation made orthonormal to rounding. \pre it is rigid to rigid_tolerance
[[nodiscard]] RigidTransform straightened(const RigidTransform& pose) noexcept;

} // namespace proxima
