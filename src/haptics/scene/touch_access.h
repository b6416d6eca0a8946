// Conversions between public bodies and scenes and their implementations.
#pragma once

#include "haptics/scene/contact_body.h"
#include "haptics/scene/moving_surface.h"
#include "haptics/scene/scene_views.h"
#include "proxima/touch_scene.h"

#include <memory>
#include <utility>

namespace proxima {

/// The library's access to the parts of TouchBody and TouchScene.
class PROXIMA_HIDDEN TouchAccess {
public:
    [[nodiscard]] static TouchBody wrap(std::shared_ptr<const ContactBody> body) noexcept
    {
        return TouchBody(std::move(body));
    }
    [[nodiscard]] static std::shared_ptr<const ContactBody> unwrap(const TouchBody& body) noexcept
    {
        return body.body_;
    }
    [[nodiscard]] static const ContactBody& body(const TouchBody& body) noexcept
    {
        return *body.body_;
    }
    [[nodiscard]] static MovingSurface& surface(TouchScene& scene) noexcept
    {
        return scene.views_->own();
    }
    [[nodiscard]] static const MovingSurface& surface(const TouchScene& scene) noexcept
    {
        return std::as_const(*scene.views_).own();
    }
    [[nodiscard]] static SceneViews& views(TouchScene& scene) noexcept { return *scene.views_; }
    [[nodiscard]] static const SceneInput& input(const TouchScene& scene) noexcept
    {
        return scene.views_->input();
    }
};

[[nodiscard]] inline const ContactBody& contact_body(const TouchBody& body) noexcept
{
    return TouchAccess::body(body);
}

/// The views of a scene, of which each renderer takes one. \pre the scene was not moved from
[[nodiscard]] inline SceneViews& scene_views(TouchScene& scene) noexcept
{
    return TouchAccess::views(scene);
}

/// What the application said of the objects. \pre the scene was not moved from
[[nodiscard]] inline const SceneInput& scene_input(const TouchScene& scene) noexcept
{
    return TouchAccess::input(scene);
}

/// The scene's own view, whose address does not change while the scene lives and which its first
/// renderer advances. \pre the scene was not moved from
[[nodiscard]] inline MovingSurface& moving_surface(TouchScene& scene) noexcept
{
    return TouchAccess::surface(scene);
}
[[nodiscard]] inline const MovingSurface& moving_surface(const TouchScene& scene) noexcept
{
    return TouchAccess::surface(scene);
}

} // namespace proxima
