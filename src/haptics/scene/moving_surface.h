// A tool's view of a TouchScene (touch_scene.h): the triangles of all objects at their poses of this
// tick, in the scene's frame. So different objects can form a corner.
//
// Each tool has a view of its own (scene_views.h), with what it keeps and with the poses of its own
// ticks. Poses depend on the scene's time alone (scene_clock.h), so those of all tools agree.
//
// Each object is queried in its own frame, in which near triangles are cached from tick to tick
// (object_cache.h); only these are moved into the scene's frame.
//
// An object whose shape changes has vertices on their way from one shape to the next: shapes come as
// bodies do, and the servo loop keeps two, for a tick may begin on the way to one and end on the way to
// another.
#pragma once

#include "haptics/scene/contact_body.h"
#include "haptics/scene/material_change.h"
#include "haptics/scene/object_cache.h"
#include "haptics/scene/object_trajectory.h"
#include "haptics/scene/scene_clock.h"
#include "haptics/scene/scene_input.h"
#include "haptics/scene/shape_change.h"
#include "haptics/surface/changing_surface.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/moving_triangle.h"
#include "haptics/surface/surface_properties.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace proxima {

/// An object in a tick of the servo loop.
struct PROXIMA_HIDDEN SceneObject {
    const ContactBody* body = nullptr;
    RigidTransform before; ///< pose of the last tick
    RigidTransform now;
    bool moved = false;     ///< the pose
    bool changed = false;   ///< the shape, of which `body` is the next
    bool exchanged = false; ///< the body
};

/// Queries by one servo thread alone, for they cache near triangles; results do not depend on the
/// cache.
class MovingSurface final : public ContactSurface, public SurfaceProperties {
public:
    /// A view of all objects of the input, where they are now. Refers to the input, which tells shapes.
    MovingSurface(SceneInput& input, std::size_t tool);

    /// Adds an object that the input has. \pre its id is the next
    void add(ObjectId id);

    /// Goes on at the scene's time, with another servo loop.
    void start() noexcept;

    /// Like TouchScene::advance().
    SceneTick advance(double seconds) noexcept;
    [[nodiscard]] std::size_t object_count() const noexcept { return objects_.size(); }
    [[nodiscard]] SceneObject object(ObjectId id) const noexcept;

    /// The velocity in the last tick of a point that moves with the object's pose, per second.
    [[nodiscard]] Vec3 velocity_at(ObjectId id, const Vec3& p) const noexcept;

    /// The velocity in the last tick of a point that moves with a triangle of the scene, per second.
    [[nodiscard]] Vec3 velocity_at(TriangleId triangle, const Vec3& p) const noexcept;

    /// Whether the object surely keeps this distance from a motion of the last tick, which is
    /// straight in the object's frame.
    [[nodiscard]] bool keeps_clear(ObjectId id, const Vec3& from, const Vec3& to,
                                   double distance) const noexcept;

    /// Whether the object, where it is now, is farther than this from p and does not contain it.
    [[nodiscard]] bool is_apart(ObjectId id, const Vec3& p, double distance) const noexcept;
    /// Whether the object's last body, where it was before this tick, is farther than this from p.
    /// \pre object(id).exchanged
    [[nodiscard]] bool was_apart(ObjectId id, const Vec3& p, double distance) const noexcept;

    /// Like collect_along(), of one object in its own frame, with the ids of its own mesh.
    [[nodiscard]] std::size_t collect_of(ObjectId id, const Vec3& p, const Vec3& motion,
                                         double distance,
                                         std::span<ContactTriangle> buffer) const noexcept;

    /// Like collect_of(), of an object that changed its shape in the last tick: the triangles that
    /// may come within the distance of a point that moves meanwhile. `near` is scratch memory. \pre
    /// object(id).changed
    [[nodiscard]] std::size_t collect_changing(ObjectId id, const Vec3& p, const Vec3& motion,
                                               double distance, std::span<ContactTriangle> near,
                                               std::span<MovingTriangle> buffer) const noexcept;

    /// A triangle of the scene, in the frame of its object. \pre object(object_of(triangle)).changed
    [[nodiscard]] MovingTriangle changing_triangle(TriangleId triangle) const noexcept;

    /// Work counters of all objects since they were added.
    [[nodiscard]] ContactWork work() const noexcept;

    // ContactSurface, of the present poses.
    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return scale_; }
    [[nodiscard]] std::size_t collect(const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) const noexcept override
    {
        return collect_along(p, Vec3::Zero(), distance, buffer);
    }
    [[nodiscard]] std::size_t
    collect_along(const Vec3& p, const Vec3& motion, double distance,
                  std::span<ContactTriangle> buffer) const noexcept override;
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override;
    [[nodiscard]] double clearance_beyond(const Vec3& p, double wanted) const noexcept override;
    [[nodiscard]] Vec3 nearest_exit(const Vec3& p) const noexcept override;
    /// A new number in each tick in which something moved or was exchanged.
    [[nodiscard]] std::uint64_t edition() const noexcept override { return edition_; }

    // SurfaceProperties.
    [[nodiscard]] std::optional<SurfaceMaterial>
    material(TriangleId triangle) const noexcept override;
    [[nodiscard]] Vec3 shaded_normal(TriangleId triangle,
                                     const Vec3& point) const noexcept override;
    [[nodiscard]] const SurfaceTexture* texture(TriangleId triangle) const noexcept override;
    [[nodiscard]] RigidTransform pose(TriangleId triangle) const noexcept override;

private:
    /// A ball that is known to be free of an object at its present pose, in the scene's frame.
    struct FreeBall {
        Vec3 center = Vec3::Zero();
        double reach = -1;
    };
    /// A path of the last tick that is known to be free of an object.
    struct FreePath {
        Vec3 from = Vec3::Zero();
        Vec3 to = Vec3::Zero();
        double length = 0;    ///< in the object's frame
        double reach = -1;    ///< round the first position
        bool is_near = false; ///< not known to be free, and not tested again in this tick
    };
    struct Slot {
        Slot(Snapshot<ObjectCourse>& told_courses, Snapshot<MaterialCourse>& told_materials)
            : courses(told_courses), materials(told_materials)
        {}

        ShapeSnapshot shapes;
        Snapshot<ObjectCourse>& courses;     ///< the input's
        Snapshot<MaterialCourse>& materials; ///< the input's
        ObjectTrajectory trajectory;
        ObjectCache cache;
        FreeBall free_ball;
        FreePath free_path;
        ChangingSurface shape_before; ///< at the tick's begin, of an object changed or exchanged
        ChangingSurface shape;        ///< at its end, of an object with a change
        double part = 1;              ///< of the change
        double stretch = 0;     ///< no vertex moved farther in the last tick; 0 where none moved
        bool exchanged = false; ///< in the last tick

        [[nodiscard]] const ContactBody& body() const noexcept { return *shapes.reading().body; }
        [[nodiscard]] const ContactSurface& surface() const noexcept
        {
            return shapes.reading().change == nullptr ? body().surface() : shape;
        }
        [[nodiscard]] const Box& bounds() const noexcept
        {
            const auto& change = shapes.reading().change;
            return change == nullptr ? body().bounds() : change->bounds();
        }
    };

    void measure() noexcept;
    /// Takes what the application gave, and moves vertices. Returns whether the body was exchanged.
    static bool advance_shape(Slot& slot, SceneTime time) noexcept;
    /// p of the object's frame, or if the object contains it a position outside.
    [[nodiscard]] Vec3 exit_from(const Slot& slot, const Vec3& local) const noexcept;
    /// A lower bound of the object's distance from a position of its frame without a query.
    [[nodiscard]] double known_clearance(Slot& slot, const Vec3& local) const noexcept;
    /// The rounding of a position that is moved between frames.
    [[nodiscard]] double frame_margin(const Vec3& p) const noexcept;

    SceneInput& input_;
    std::size_t tool_;
    ToolClock clock_;
    SurfaceScale scale_;
    double rounding_ = 0; ///< of the part of that which is due to the scale's reach
    double tick_seconds_ = 1e-3;
    std::uint64_t edition_ = new_edition();
    std::vector<std::unique_ptr<Slot>> objects_;
};

} // namespace proxima
