// How an object of a scene goes from where it is to where the application says.
//
//     application   now and then        "in 20 ms it is there; then it goes on at this velocity"
//     servo loop    every millisecond   a place on the way: straight, turning evenly about one axis
//
// An application that says poses at 50 Hz gives 1/50 s: the object is then a period late and never
// jumps. One that knows velocities gives them, and the object coasts on until it hears more.
#pragma once

#include "proxima/geometry.h"

namespace proxima {

/// The word on one object. Lengths in the scene's unit.
struct ObjectMotion {
    RigidTransform pose = {};     ///< where it will be
    double seconds = 0;           ///< until it is there; 0 = in the next tick
    Vec3 velocity = Vec3::Zero(); ///< from then on, of the object's origin, per second
    Vec3 spin = Vec3::Zero();     ///< from then on, radians per second about the scene's axes
    double coast_seconds = 0;     ///< from then on at most: then it stands still
};

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
