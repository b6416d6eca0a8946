// What an engine changes of an object in a tick: a motion, a material or both. Recordings keep them by
// tick, so that a session can be replayed without the engine.
#pragma once

#include "proxima/result.h"
#include "proxima/touch_scene.h"

#include <cstdint>

namespace proxima {

struct SceneMessage {
    std::uint64_t tick = 0; ///< before which it is applied, from 0
    ObjectId object{};
    bool has_motion = false;
    bool has_material = false;
    ObjectMotion motion;
    SurfaceMaterial material;
    double material_seconds = 0; ///< in which the material changes
};

/// Whether apply() would succeed. noexcept, no allocation, by the thread that moves the object.
[[nodiscard]] bool is_applicable(const SceneMessage& message, const TouchScene& scene) noexcept;

/// Gives motion and material to the scene. Errors: those of TouchScene::move and set_material;
/// invalid_argument for an object that the scene does not have. No allocation where it succeeds.
[[nodiscard]] Status apply(const SceneMessage& message, TouchScene& scene);

} // namespace proxima
