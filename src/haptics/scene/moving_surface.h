// The surface of a TouchScene (touch_scene.h): the triangles of all objects at their poses of this
// tick, in the scene's frame. So different objects can form a corner.
//
// Each object is queried in its own frame, in which near triangles are cached from tick to tick
// (object_cache.h); only these are moved into the scene's frame.
#pragma once

#include "haptics/loop/snapshot.h"
#include "haptics/scene/contact_body.h"
#include "haptics/scene/object_cache.h"
#include "haptics/scene/object_trajectory.h"
#include "haptics/surface/contact_surface.h"
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
struct SceneObject {
    const ContactBody* body = nullptr;
    RigidTransform before; ///< pose of the last tick
    RigidTransform now;
    bool moved = false;
};

/// Queries by the servo thread alone, for they cache near triangles; results do not depend on the
/// cache. move() and exchange() by one other thread for each object.
class MovingSurface final : public ContactSurface, public SurfaceProperties {
public:
    // Like those of TouchScene.
    explicit MovingSurface(const Box& bounds);
    [[nodiscard]] Result<ObjectId> add(std::shared_ptr<const ContactBody> body,
                                       const RigidTransform& pose);
    [[nodiscard]] Status move(ObjectId object, const ObjectMotion& motion);
    [[nodiscard]] Status exchange(ObjectId object, std::shared_ptr<const ContactBody> body);
    SceneTick advance(double seconds) noexcept;
    [[nodiscard]] std::size_t object_count() const noexcept { return objects_.size(); }
    [[nodiscard]] SceneObject object(ObjectId id) const noexcept;

    /// The velocity in the last tick of a point that moves with the object, per second.
    [[nodiscard]] Vec3 velocity_at(ObjectId id, const Vec3& p) const noexcept;

    /// Whether the object surely keeps this distance from a motion of the last tick, which is
    /// straight in the object's frame.
    [[nodiscard]] bool keeps_clear(ObjectId id, const Vec3& from, const Vec3& to,
                                   double distance) const noexcept;

    /// Like collect_along(), of one object in its own frame, with the ids of its own mesh.
    [[nodiscard]] std::size_t collect_of(ObjectId id, const Vec3& p, const Vec3& motion,
                                         double distance,
                                         std::span<ContactTriangle> buffer) const noexcept;

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

private:
    using BodySnapshot = Snapshot<std::shared_ptr<const ContactBody>>;
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
        Snapshot<ObjectMotion> motions;
        BodySnapshot bodies;
        ObjectTrajectory trajectory; ///< this and the next three: the servo thread's
        ObjectCache cache;
        FreeBall free_ball;
        FreePath free_path;
        Box newest_bounds;          ///< the application's: of the body given last
        RigidTransform newest_pose; ///< the application's: of the motion given last

        [[nodiscard]] const ContactBody& body() const noexcept { return *bodies.reading(); }
    };

    [[nodiscard]] bool contains(const Box& bounds, const RigidTransform& pose) const;
    void measure() noexcept;
    /// A lower bound of the object's distance from a position of its frame without a query.
    [[nodiscard]] double known_clearance(Slot& slot, const Vec3& local) const noexcept;
    /// The rounding of a position that is moved between frames.
    [[nodiscard]] double frame_margin(const Vec3& p) const noexcept;

    Box bounds_;
    SurfaceScale scale_;
    double rounding_ = 0; ///< of the bounds' part of that
    double tick_seconds_ = 1e-3;
    std::uint64_t edition_ = new_edition();
    std::vector<std::unique_ptr<Slot>> objects_;
};

} // namespace proxima
