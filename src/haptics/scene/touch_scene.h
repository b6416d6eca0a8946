// Several objects to touch, which move and change while they are touched.
//
//     TouchScene scene(room);
//     const ObjectId cup = *scene.add(std::move(body), pose);      // before the first tick
//     HapticRenderer renderer(scene, map, device);                 // its ticks move the scene
//     scene.move(cup, {.pose = next, .seconds = 0.02});            // any time, by another thread
//     scene.exchange(cup, std::move(other_body));                  // any time, by another thread
//
//     application ──motions, bodies──▶ snapshots ──▶ servo loop      neither waits for the other
//
// A proxy sees one surface: the triangles of all objects, where they stand in this tick, in the
// scene's frame. So corners that different objects form are corners. Questions go to each object in
// the object's own frame, where what is near is kept from tick to tick (object_cache.h); only what
// is near is moved into the scene's.
#pragma once

#include "haptics/loop/snapshot.h"
#include "haptics/scene/object_cache.h"
#include "haptics/scene/object_motion.h"
#include "haptics/scene/touch_body.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/surface_feel.h"
#include "proxima/result.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace proxima {

enum class ObjectId : std::uint32_t {};

[[nodiscard]] constexpr std::uint32_t index(ObjectId id) noexcept
{
    return static_cast<std::uint32_t>(id);
}

/// No scene has more objects.
inline constexpr std::size_t max_scene_objects = 64;

/// A triangle of a scene is named by its object and its own name there, in one number: by object,
/// then by triangle.
inline constexpr unsigned scene_triangle_bits = 26;

[[nodiscard]] constexpr TriangleId scene_triangle(ObjectId object, TriangleId triangle) noexcept
{
    return TriangleId{index(object) << scene_triangle_bits | index(triangle)};
}
[[nodiscard]] constexpr ObjectId object_of(TriangleId scene_triangle) noexcept
{
    return ObjectId{index(scene_triangle) >> scene_triangle_bits};
}
[[nodiscard]] constexpr TriangleId triangle_of(TriangleId scene_triangle) noexcept
{
    return TriangleId{index(scene_triangle) & ((1U << scene_triangle_bits) - 1)};
}

/// An object as the servo loop sees it in a tick.
struct SceneObject {
    const TouchBody* body = nullptr;
    RigidTransform before; ///< where it stood in the last tick
    RigidTransform now;
    bool moved = false;
};

/// What a tick brought.
struct SceneTick {
    bool moved = false;     ///< some object
    bool exchanged = false; ///< some object's body
};

/// Questions by the servo thread alone, for they keep what is near; what they answer does not
/// depend on it. move() and exchange() by one other thread for each object.
class TouchScene final : public ContactSurface, public SurfaceFeel {
public:
    /// Objects stay within the room, whose size says how exact places of the scene are: gaps are
    /// 2^-30 of it. \pre the room is not empty
    explicit TouchScene(const Box& room);

    /// Before the first tick. Error invalid_argument: no more objects, the pose is not rigid, or
    /// the object reaches out of the room.
    [[nodiscard]] Result<ObjectId> add(std::unique_ptr<const TouchBody> body,
                                       const RigidTransform& pose);

    /// Where it is to go from now on; whatever was said before is forgotten. Wait-free. Errors
    /// invalid_argument: numbers that are not finite or negative times, a pose that is not rigid,
    /// or out of the room, also where it coasts to.
    [[nodiscard]] Status move(ObjectId object, const ObjectMotion& motion);

    /// Another body in its place from the next tick on; the old one is freed here, by the next
    /// exchange or with the scene, never by the servo thread. Error invalid_argument: out of the
    /// room.
    [[nodiscard]] Status exchange(ObjectId object, std::unique_ptr<const TouchBody> body);

    /// One tick on. The servo thread's; noexcept, wait-free, no allocation, nothing freed.
    /// \pre seconds > 0
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
    using BodySnapshot = Snapshot<std::unique_ptr<const TouchBody>>;
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

        [[nodiscard]] const TouchBody& body() const noexcept { return *bodies.reading(); }
    };

    [[nodiscard]] bool holds(const Box& bounds, const RigidTransform& pose) const;
    void measure() noexcept;
    /// No part of the object is nearer to a place of its frame than this, as is known without
    /// asking.
    [[nodiscard]] double known_clearance(Slot& slot, const Vec3& local) const noexcept;
    /// What moving a place there is off by.
    [[nodiscard]] double frame_margin(const Vec3& p) const noexcept;

    Box room_;
    SurfaceScale scale_;
    double rounding_ = 0; ///< of a place that is moved between frames
    double tick_seconds_ = 1e-3;
    std::uint64_t edition_ = new_edition();
    std::vector<std::unique_ptr<Slot>> objects_;
};

} // namespace proxima
