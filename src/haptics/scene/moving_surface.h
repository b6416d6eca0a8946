// The surface of a TouchScene (touch_scene.h): the triangles of all objects, where they stand in
// this tick, in the scene's frame. So corners that different objects form are corners.
//
// Questions go to each object in the object's own frame, where what is near is kept from tick to
// tick (object_cache.h); only what is near is moved into the scene's.
#pragma once

#include "haptics/loop/snapshot.h"
#include "haptics/scene/contact_body.h"
#include "haptics/scene/object_cache.h"
#include "haptics/scene/object_course.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/surface_feel.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace proxima {

/// An object as the servo loop sees it in a tick.
struct SceneObject {
    const ContactBody* body = nullptr;
    RigidTransform before; ///< where it stood in the last tick
    RigidTransform now;
    bool moved = false;
};

/// Questions by the servo thread alone, for they keep what is near; what they answer does not
/// depend on it. move() and exchange() by one other thread for each object.
class MovingSurface final : public ContactSurface, public SurfaceFeel {
public:
    // Those of TouchScene.
    explicit MovingSurface(const Box& bounds);
    [[nodiscard]] Result<ObjectId> add(std::unique_ptr<const ContactBody> body,
                                       const RigidTransform& pose);
    [[nodiscard]] Status move(ObjectId object, const ObjectMotion& motion);
    [[nodiscard]] Status exchange(ObjectId object, std::unique_ptr<const ContactBody> body);
    SceneTick advance(double seconds) noexcept;
    [[nodiscard]] std::size_t object_count() const noexcept { return objects_.size(); }
    [[nodiscard]] SceneObject object(ObjectId id) const noexcept;

    /// How fast a point that moves with the object is, per second, in the last tick.
    [[nodiscard]] Vec3 velocity_at(ObjectId id, const Vec3& p) const noexcept;

    /// p, or where p is inside of closed bodies a place at the surface of one and inside of none;
    /// inside of one still where many overlap.
    [[nodiscard]] Vec3 nearest_exit(const Vec3& p) const noexcept;

    /// As an object sees it, what goes from one place to another in the last tick goes straight
    /// from where it stood to where it is. True only if no triangle of the object comes within the
    /// distance of that way.
    [[nodiscard]] bool keeps_clear(ObjectId id, const Vec3& from, const Vec3& to,
                                   double distance) const noexcept;

    /// Of one object, in its own frame and with its own names: all triangles that come within
    /// `distance` of the straight way from p, and perhaps some that do not. Returns how many, or
    /// any number of more than the buffer's size where that is full.
    [[nodiscard]] std::size_t collect_of(ObjectId id, const Vec3& p, const Vec3& way,
                                         double distance,
                                         std::span<ContactTriangle> buffer) const noexcept;

    /// What the objects' surfaces were asked for, since they were added.
    [[nodiscard]] ContactWork work() const noexcept;

    // Surface, as the objects stand now.
    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return scale_; }
    [[nodiscard]] std::size_t collect(const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) const noexcept override
    {
        return collect_along(p, Vec3::Zero(), distance, buffer);
    }
    [[nodiscard]] std::size_t
    collect_along(const Vec3& p, const Vec3& way, double distance,
                  std::span<ContactTriangle> buffer) const noexcept override;
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override;
    [[nodiscard]] double clearance_beyond(const Vec3& p, double wanted) const noexcept override;
    /// Another one in each tick in which something moved or was exchanged.
    [[nodiscard]] std::uint64_t edition() const noexcept override { return edition_; }

    // Feel.
    [[nodiscard]] std::optional<SurfaceMaterial>
    material(TriangleId triangle) const noexcept override;
    [[nodiscard]] Vec3 shaded_normal(TriangleId triangle,
                                     const Vec3& point) const noexcept override;

private:
    using BodySnapshot = Snapshot<std::unique_ptr<const ContactBody>>;
    /// What is known to be free of an object, in the scene's frame: round a place, as it stands.
    struct FreeBall {
        Vec3 center = Vec3::Zero();
        double reach = -1;
    };
    /// The same of the last tick's motion: from where it stood to where it is.
    struct FreeWay {
        Vec3 from = Vec3::Zero();
        Vec3 to = Vec3::Zero();
        double length = 0;    ///< as the object sees it
        double reach = -1;    ///< round the first place
        bool is_near = false; ///< something was in the way: not worth asking again in this tick
    };
    struct Slot {
        Snapshot<ObjectMotion> motions;
        BodySnapshot bodies;
        ObjectCourse course; ///< this and the next three: the servo thread's
        ObjectCache cache;
        FreeBall free_ball;
        FreeWay free_way;
        Box newest_bounds;          ///< the application's: of the body given last
        RigidTransform newest_pose; ///< the application's: where it is to go

        [[nodiscard]] const ContactBody& body() const noexcept { return *bodies.reading(); }
    };

    [[nodiscard]] bool holds(const Box& bounds, const RigidTransform& pose) const;
    void measure() noexcept;
    /// No part of the object is nearer to a place of its frame than this, as is known without
    /// asking.
    [[nodiscard]] double known_clearance(Slot& slot, const Vec3& local) const noexcept;
    /// What moving a place there is off by.
    [[nodiscard]] double frame_margin(const Vec3& p) const noexcept;

    Box bounds_;
    SurfaceScale scale_;
    double rounding_ = 0; ///< of a place that is moved between frames
    double tick_seconds_ = 1e-3;
    std::uint64_t edition_ = new_edition();
    std::vector<std::unique_ptr<Slot>> objects_;
};

} // namespace proxima
