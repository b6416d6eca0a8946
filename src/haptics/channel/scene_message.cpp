#include "haptics/channel/scene_message.h"

#include "haptics/scene/material_change.h"
#include "haptics/scene/touch_access.h"

#include <cmath>

namespace proxima {

bool is_applicable(const SceneMessage& message, const TouchScene& scene) noexcept
{
    if (to_index(message.object) >= scene.object_count()) return false;
    if (message.has_motion &&
        scene_input(scene).motion_problem(message.object, message.motion) != nullptr)
        return false;
    const double seconds = message.material_seconds;
    return !message.has_material ||
           (is_valid(message.material) && seconds >= 0 && std::isfinite(seconds));
}

Status apply(const SceneMessage& message, TouchScene& scene)
{
    if (to_index(message.object) >= scene.object_count())
        return fail(ErrorCode::invalid_argument, "the scene has no such object");
    Status status;
    if (message.has_motion) status = scene.move(message.object, message.motion);
    if (status && message.has_material)
        status = scene.set_material(message.object, message.material, message.material_seconds);
    return status;
}

} // namespace proxima
