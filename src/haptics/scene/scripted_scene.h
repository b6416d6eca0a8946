// A scene whose objects move by scripts (object_script.h), said to it as an application does: 50
// times a second, where each object is to be a word later.
//
//     auto scripted = ScriptedScene::make(std::move(bodies), objects);
//     HapticRenderer renderer((*scripted)->scene(), map, device);
//     each tick:  (*scripted)->say(tick, 1e-3);  renderer.tick(state, 1e-3);
//
// Words come at the same ticks in every session: what was felt replays bit for bit.
#pragma once

#include "haptics/scene/object_script.h"
#include "haptics/surface/surface_feel.h"
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

/// An object as a session has it: all but its mesh, of which it has the fingerprint.
struct ScriptedObject {
    std::uint64_t mesh_fingerprint = 0;
    RigidTransform pose; ///< at the beginning
    ObjectScript script;
    std::optional<SurfaceMaterial> material; ///< none: the renderer's own
};

/// say(), rewind() and the scene's ticks by one thread.
class ScriptedScene {
public:
    /// A body for each object, made with its material. Errors: check_script's and
    /// TouchScene::add's.
    [[nodiscard]] static Result<std::unique_ptr<ScriptedScene>>
    make(std::vector<TouchBody> bodies, std::span<const ScriptedObject> objects);

    [[nodiscard]] TouchScene& scene() noexcept { return scene_; }
    [[nodiscard]] const TouchScene& scene() const noexcept { return scene_; }
    [[nodiscard]] std::span<const ScriptedObject> objects() const noexcept { return objects_; }

    /// No object ever leaves it.
    [[nodiscard]] const Box& reach() const noexcept { return reach_; }

    /// Before a tick, counted from 0: says what there is to say. noexcept, no allocation.
    /// \pre tick_seconds > 0
    void say(std::uint64_t tick, double tick_seconds) noexcept;

    /// All objects back to where they began, as new. No renderer has the scene.
    void rewind() noexcept;

private:
    ScriptedScene(const Box& reach, std::span<const ScriptedObject> objects);

    Box reach_;
    TouchScene scene_;
    std::vector<ScriptedObject> objects_;
};

/// All triangles where they stand, in the order of scene_triangle(). Vertices are not shared
/// between objects. Error: make_triangle_mesh's.
[[nodiscard]] Result<TriangleMesh> standing_mesh(const TouchScene& scene);

} // namespace proxima
