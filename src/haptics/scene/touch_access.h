// Conversions between public bodies and scenes and their implementations.
#pragma once

#include "haptics/scene/contact_body.h"
#include "haptics/scene/moving_surface.h"
#include "proxima/touch_scene.h"

#include <memory>
#include <utility>

namespace proxima {

/// The library's access to the parts of TouchBody and TouchScene.
class TouchAccess {
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
        return *scene.surface_;
    }
    [[nodiscard]] static const MovingSurface& surface(const TouchScene& scene) noexcept
    {
        return *scene.surface_;
    }
};

[[nodiscard]] inline const ContactBody& contact_body(const TouchBody& body) noexcept
{
    return TouchAccess::body(body);
}

/// The scene's surface, whose address does not change while the scene lives. A renderer takes the
/// scene itself, for it has to advance it. \pre the scene was not moved from
[[nodiscard]] inline MovingSurface& moving_surface(TouchScene& scene) noexcept
{
    return TouchAccess::surface(scene);
}
[[nodiscard]] inline const MovingSurface& moving_surface(const TouchScene& scene) noexcept
{
    return TouchAccess::surface(scene);
}

} // namespace proxima
