// A scene whose objects move by scripts (object_script.h). It gets motions as from an application: 50
// times a second, the pose of each object at the next update.
//
//     auto scripted = ScriptedScene::make(bodies, objects);
//     auto renderer = make_haptic_renderer((*scripted)->scene(), map, device);
//     each tick:  (*scripted)->send_motions(tick, 1e-3);  renderer->tick(state, 1e-3);
//
// Updates come in the same ticks of every session, so that it can be replayed bit for bit.
#pragma once

#include "haptics/scene/object_script.h"
#include "haptics/surface/surface_properties.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// An object of a session: all but its mesh, which a fingerprint stands for.
struct ScriptedObject {
    std::uint64_t mesh_fingerprint = 0;
    RigidTransform pose; ///< at the beginning
    ObjectScript script;
    std::optional<SurfaceMaterial> material;    ///< none: the renderer's own
    std::optional<SurfaceTexture> texture = {}; ///< none: the renderer's own
};

/// send_motions(), rewind() and the scene's ticks by one thread.
class ScriptedScene {
public:
    /// With a body for each object, built with its material and texture. Where somebody else moves the objects as
    /// well (scene_message.h), the scene reaches `room` diagonals beyond the scripts' bounds. Errors:
    /// those of check_script and TouchScene::add. \pre room >= 0
    [[nodiscard]] static Result<std::unique_ptr<ScriptedScene>>
    make(std::span<const TouchBody> bodies, std::span<const ScriptedObject> objects,
         double room = 0);

    [[nodiscard]] TouchScene& scene() noexcept { return scene_; }
    [[nodiscard]] const TouchScene& scene() const noexcept { return scene_; }
    [[nodiscard]] std::span<const ScriptedObject> objects() const noexcept { return objects_; }

    /// No object ever leaves it by its script, but by rounding.
    [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }

    /// Sends the motions that are due before a tick, counted from 0. noexcept, no allocation.
    /// \pre tick_seconds > 0
    void send_motions(std::uint64_t tick, double tick_seconds) noexcept;

    /// Moves all objects back to their first poses. \pre no renderer has the scene
    void rewind() noexcept;

private:
    ScriptedScene(Box bounds, const Box& scene_bounds, std::span<const ScriptedObject> objects);

    Box bounds_;
    TouchScene scene_;
    std::vector<ScriptedObject> objects_;
};

/// All triangles at the present poses, in the order of scene_triangle(). Objects share no vertices.
/// Errors: those of make_triangle_mesh.
[[nodiscard]] Result<TriangleMesh> scene_mesh(const TouchScene& scene);

} // namespace proxima
