// The trajectory of an object of a scene to the pose that the application gave (ObjectMotion).
//
//     application   now and then        a pose, the time until then, and the velocity after it
//     servo loops   every millisecond   a pose in between: a pivot goes straight, and the object turns
//                                       evenly about an axis through it
//
// The pivot is the object's origin, or for scripts (object_script.h) its middle.
//
// A motion begins where the one before it was at that time. So its poses depend on the scene's time
// alone, and all tools compute the same ones.
#pragma once

#include "haptics/scene/scene_clock.h"
#include "proxima/geometry.h"
#include "proxima/touch_scene.h"

#include <array>
#include <cstddef>

namespace proxima {

/// Where an object is that has coasted from the motion's pose for so many seconds.
[[nodiscard]] RigidTransform coasted(const ObjectMotion& motion, double seconds) noexcept;

/// A motion of an object that began at a time of the scene. A value.
class ObjectCourse {
public:
    ObjectCourse() = default;
    /// At rest, with its rotation made orthonormal to rounding. \pre it is rigid to rigid_tolerance
    explicit ObjectCourse(const RigidTransform& pose) noexcept;

    /// The course that leaves this one at a time. The pivot, a point of the object's frame, goes straight
    /// to where the pose has it. \pre the motion's pose is rigid to rigid_tolerance
    [[nodiscard]] ObjectCourse continued(const ObjectMotion& motion, SceneTime start,
                                         const Vec3& pivot = Vec3::Zero()) const noexcept;

    /// 0.2 us.
    [[nodiscard]] RigidTransform pose_at(SceneTime time) const noexcept;

    /// Whether the pose stays the same from this time on.
    [[nodiscard]] bool rests_at(SceneTime time) const noexcept;

    [[nodiscard]] SceneTime start() const noexcept { return start_; }

    /// What the application gave last.
    [[nodiscard]] const ObjectMotion& motion() const noexcept { return motion_; }

private:
    /// When it is at the pose, s. Half a nanosecond per tick is lost in the scene's time.
    [[nodiscard]] double arrival() const noexcept { return motion_.seconds * (1 - 1e-9); }

    ObjectMotion motion_;
    RigidTransform from_;
    Vec3 pivot_ = Vec3::Zero();
    Vec3 turn_ = Vec3::Zero(); ///< rotation from `from_` to the pose: axis times angle
    SceneTime start_ = 0;
};

/// The pose of an object, tick by tick. noexcept, no allocation, 0.2 us.
class ObjectTrajectory {
public:
    ObjectTrajectory() = default;
    ObjectTrajectory(const ObjectCourse& course, SceneTime time) noexcept;

    /// Takes another course once the time is there at which it begins, which is ahead for a tool that
    /// lags behind. So courses wait; one that finds no room takes the place of the last of them.
    void follow(const ObjectCourse& course) noexcept;

    /// As if it had been there at rest before.
    void start(SceneTime time) noexcept;

    /// Advances by a tick that ends at this time.
    void advance(SceneTime time) noexcept;

    [[nodiscard]] const RigidTransform& before() const noexcept { return before_; }
    [[nodiscard]] const RigidTransform& now() const noexcept { return now_; }
    [[nodiscard]] bool moved() const noexcept { return moved_; } ///< in the last tick

private:
    /// A tool lags behind by a few ticks (scene_clock.h), and each tick brings one course at most.
    static constexpr std::size_t most_waiting = 8;

    ObjectCourse course_;
    std::array<ObjectCourse, most_waiting> waiting_; ///< the earliest first
    std::size_t waiting_count_ = 0;
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

} // namespace proxima
