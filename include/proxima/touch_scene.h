// Objects to touch, which move and change while they are touched.
//
//     TouchScene scene({Vec3(-1, -1, -1), Vec3(1, 1, 1)});          // objects stay within this box
//     auto body = build_touch_body(mesh, {.material = SurfaceMaterial{.stiffness = 300}});
//     const ObjectId cup = *scene.add(std::move(*body), pose);      // before the first tick
//     HapticRenderer renderer(scene, map, device.info().limits);    // its ticks advance the scene
//     scene.move(cup, {.pose = next, .seconds = 0.02});             // any time, by another thread
//     scene.exchange(cup, std::move(*other_body));                  // any time, by another thread
//
//     application ──motions, bodies──▶ snapshots ──▶ servo loop      neither waits for the other
//
// All objects together are one surface: a corner that several of them form is a corner. Nothing is
// passed while objects move, however thin and fast they are; touched objects carry the proxy along.
//
// Lengths are in the scene's unit, which is the model's unit of the renderer's WorkspaceMap.
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

namespace proxima {

class ContactBody;
class MeshIndex;
class MovingSurface;

/// How a body feels. Limited by what the device can take.
struct SurfaceMaterial {
    double stiffness = 500;        ///< K, N/m
    double damping = 1;            ///< B, N s/m
    double static_friction = 0.4;  ///< mu_s
    double dynamic_friction = 0.3; ///< mu_d, at most mu_s
};

/// Whether forces lean towards the normals of the smooth surface that a mesh stands for.
enum class ForceShading : bool { off, on };

struct TouchBodyOptions {
    std::optional<SurfaceMaterial> material;  ///< none: the renderer's own settings
    ForceShading shading = ForceShading::off; ///< on: with smooth normals, for renderers with it on
    Execution execution = {};
};

/// A mesh with all that touching it takes. Immutable, made once, by any thread; a value that moves.
class TouchBody {
public:
    TouchBody(TouchBody&& other) noexcept;
    TouchBody& operator=(TouchBody&& other) noexcept;
    ~TouchBody();

    /// The mesh that it was built from. \pre the body was not moved from
    [[nodiscard]] const TriangleMesh& mesh() const noexcept;

private:
    friend class TouchAccess;
    explicit TouchBody(std::unique_ptr<const ContactBody> body) noexcept;

    std::unique_ptr<const ContactBody> body_; ///< not null but after a move
};

/// Builds an index with lists for the mesh, and the body. Errors: those of build_topology,
/// build_mesh_index, with_lists and build_surface_sign; invalid_argument for materials that are not
/// finite, negative, or of more dynamic than static friction.
[[nodiscard]] Result<TouchBody> build_touch_body(TriangleMesh mesh,
                                                 const TouchBodyOptions& options = {});

/// The same with an index that is built already or was loaded, whose storage the body shares.
/// Errors also: invalid_mesh or broken_invariant where the index does not hold such a mesh.
[[nodiscard]] Result<TouchBody> build_touch_body(const MeshIndex& index,
                                                 const TouchBodyOptions& options = {});

/// An object of a scene: they count from 0, in the order in which they were added.
enum class ObjectId : std::uint32_t {};

[[nodiscard]] constexpr std::uint32_t index(ObjectId id) noexcept
{
    return static_cast<std::uint32_t>(id);
}

/// No scene has more objects.
inline constexpr std::size_t max_scene_objects = 64;

/// A scene names a triangle by its object and its own id there, in one number: the id's bits, and
/// above them the object's.
inline constexpr unsigned scene_triangle_bits = 26;

[[nodiscard]] constexpr TriangleId scene_triangle(ObjectId object, TriangleId triangle) noexcept
{
    return TriangleId{index(object) << scene_triangle_bits | index(triangle)};
}
/// The object of a triangle that a scene names, as RenderTick::contacts do.
[[nodiscard]] constexpr ObjectId object_of(TriangleId scene_triangle) noexcept
{
    return ObjectId{index(scene_triangle) >> scene_triangle_bits};
}
/// That triangle's id in the object's mesh.
[[nodiscard]] constexpr TriangleId triangle_of(TriangleId scene_triangle) noexcept
{
    return TriangleId{index(scene_triangle) & ((1U << scene_triangle_bits) - 1)};
}

/// Where an object is to go: "in 20 ms it is there; then it goes on at this velocity". The servo
/// loop moves it there evenly, its origin along a straight line, its rotation about one axis.
///
/// An application that updates poses at 50 Hz sets `seconds` to 0.02: the object lags by a period
/// and never jumps. One that knows velocities gives them, and the object coasts on until the next
/// message.
struct ObjectMotion {
    RigidTransform pose = {};     ///< where it will be
    double seconds = 0;           ///< until it is there; 0 = in the next tick
    Vec3 velocity = Vec3::Zero(); ///< from then on, of the object's origin, per second
    Vec3 spin = Vec3::Zero();     ///< from then on, radians per second about the scene's axes
    double coast_seconds = 0;     ///< from then on at most: then it stands still
};

/// What a tick changed.
struct SceneTick {
    bool moved = false;     ///< some object
    bool exchanged = false; ///< some object's body
};

/// Up to 64 objects. add() before the first tick; move() and exchange() by one thread for each
/// object, at any time; everything else by the servo thread. A value that moves, while no renderer
/// has it.
class TouchScene {
public:
    /// Objects stay within the bounds, whose size says how exact positions of the scene are: a
    /// point proxy keeps 2^-30 of it from surfaces. \pre the bounds are not empty
    explicit TouchScene(const Box& bounds);
    TouchScene(TouchScene&& other) noexcept;
    TouchScene& operator=(TouchScene&& other) noexcept;
    ~TouchScene();

    /// Before the first tick. Error invalid_argument: too many objects, the pose is not rigid, or
    /// the object reaches out of the bounds.
    [[nodiscard]] Result<ObjectId> add(TouchBody body, const RigidTransform& pose);

    /// Where an object is to go from now on; earlier messages are forgotten. Wait-free. Errors
    /// invalid_argument: numbers that are not finite, negative times, a pose that is not rigid, or
    /// one out of the bounds, also where the object coasts to.
    [[nodiscard]] Status move(ObjectId object, const ObjectMotion& motion);

    /// Another body in an object's place from the next tick on. The old one is freed here, by the
    /// next exchange or with the scene, never by the servo thread. Error invalid_argument: out of
    /// the bounds.
    [[nodiscard]] Status exchange(ObjectId object, TouchBody body);

    /// One tick on: a renderer does it. noexcept, wait-free, no allocation, nothing freed.
    /// \pre seconds > 0
    SceneTick advance(double seconds) noexcept;

    [[nodiscard]] std::size_t object_count() const noexcept;

    /// Where an object is in this tick. noexcept. \pre the object was added
    [[nodiscard]] RigidTransform pose(ObjectId object) const noexcept;

    /// How fast a point that moves with an object was in the last tick, per second. noexcept.
    /// \pre the object was added
    [[nodiscard]] Vec3 velocity(ObjectId object, const Vec3& point) const noexcept;

private:
    friend class TouchAccess;

    std::unique_ptr<MovingSurface> surface_; ///< not null but after a move
};

} // namespace proxima
