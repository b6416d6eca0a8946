// What an application says of the objects of a scene, and how it reaches the tools that touch them.
//
//                      ┌──snapshots──▶ MovingSurface of tool 0 ──▶ its servo loop
//     application ──▶ SceneInput
//                      └──snapshots──▶ MovingSurface of tool 1 ──▶ its servo loop
//
// Each tool has snapshots of its own, so no servo loop waits. Those of motions and materials are there for
// every tool from the beginning and are always written, so that giving them takes no lock. Those of shapes keep
// bodies alive: a tool brings its own and takes them away again.
#pragma once

#include "haptics/loop/snapshot.h"
#include "haptics/scene/contact_body.h"
#include "haptics/scene/material_change.h"
#include "haptics/scene/object_trajectory.h"
#include "haptics/scene/scene_clock.h"
#include "haptics/scene/shape_change.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace proxima {

/// rad/s: no object spins faster about any axis, so that its angle stays a number.
inline constexpr double most_spin = 1e4;

/// Error invalid_argument for a body of more triangles than scene_triangle() can name.
[[nodiscard]] Status check_scene_triangles(std::size_t count);

/// The shape that the application gave an object last.
struct SceneShape {
    std::shared_ptr<const ContactBody> body;
    std::shared_ptr<const ShapeChange> change; ///< to the body; null where it is there at once
    SceneTime start = 0;                       ///< of the change
    std::uint64_t exchanges = 0;               ///< until then
    double travelled = 0; ///< no vertex moved farther since then, by all changes together
};

/// A tool reads one value, and the one before as well.
using ShapeSnapshot = Snapshot<SceneShape, 2>;

/// add() before any tick; move(), exchange(), change_shape() and set_material() by one thread for each
/// object;
/// join() and leave() by any thread at any time.
class SceneInput {
public:
    // Like those of TouchScene.
    explicit SceneInput(const Box& bounds);
    [[nodiscard]] Result<ObjectId> add(std::shared_ptr<const ContactBody> body,
                                       const RigidTransform& pose);
    /// The pivot, a point of the object's frame, goes straight to where the motion's pose has it.
    [[nodiscard]] Status move(ObjectId object, const ObjectMotion& motion,
                              const Vec3& pivot = Vec3::Zero());
    [[nodiscard]] Status exchange(ObjectId object, std::shared_ptr<const ContactBody> body);
    [[nodiscard]] Status change_shape(ObjectId object, std::shared_ptr<const ContactBody> body,
                                      double seconds);
    [[nodiscard]] Status set_material(ObjectId object, const SurfaceMaterial& material,
                                      double seconds);

    /// Why move() would refuse a motion; null where it would not. noexcept, by the thread that moves
    /// the object. \pre the object was added
    [[nodiscard]] const char* motion_problem(ObjectId object,
                                             const ObjectMotion& motion) const noexcept;
    [[nodiscard]] std::size_t object_count() const noexcept { return objects_.size(); }

    [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }
    [[nodiscard]] SceneClock& clock() noexcept { return clock_; }

    /// The motions of an object for a tool, which is their reader.
    [[nodiscard]] Snapshot<ObjectCourse>& courses(ObjectId object, std::size_t tool) noexcept
    {
        return objects_[to_index(object)]->courses[tool];
    }
    /// The materials of an object for a tool, which is their reader.
    [[nodiscard]] Snapshot<MaterialCourse>& materials(ObjectId object, std::size_t tool) noexcept
    {
        return objects_[to_index(object)]->materials[tool];
    }
    /// The body that an object was given last. Any thread. \pre the object was added
    [[nodiscard]] std::shared_ptr<const ContactBody> body(ObjectId object);
    /// Writes the shape of an object, and all later ones, until the tool leaves. It refers to
    /// `shapes`.
    void join(ObjectId object, std::size_t tool, ShapeSnapshot& shapes);
    void leave(std::size_t tool);

private:
    struct Object {
        explicit Object(const ObjectCourse& start);

        std::array<Snapshot<ObjectCourse>, max_scene_tools> courses;
        std::array<Snapshot<MaterialCourse>, max_scene_tools> materials;
        std::array<ShapeSnapshot*, max_scene_tools> shapes{}; ///< null: no such tool
        ObjectCourse course;                                  ///< given last
        MaterialCourse material;                              ///< given last
        SceneShape shape;                                     ///< given last
    };

    [[nodiscard]] Object& object(ObjectId id);
    /// Error invalid_argument where no object has this id.
    [[nodiscard]] Result<Object*> find(ObjectId id);
    /// Whether a box in a pose is within the bounds, with a margin along each axis.
    [[nodiscard]] bool contains(const Box& box, const RigidTransform& pose,
                                const Vec3& margin = Vec3::Zero()) const noexcept;
    /// Whether a box is within the bounds from the motion's pose on.
    [[nodiscard]] bool contains_coast(const Box& box, const ObjectMotion& motion) const noexcept;
    /// Whether a box is within the bounds where the object is now, and where it goes.
    [[nodiscard]] bool contains_course(const Box& box, const ObjectCourse& course) const noexcept;
    void publish(Object& object, SceneShape shape);

    Box bounds_;
    SceneClock clock_;
    std::mutex mutex_; ///< of all shapes; no servo loop takes it
    std::vector<std::unique_ptr<Object>> objects_;
};

} // namespace proxima
