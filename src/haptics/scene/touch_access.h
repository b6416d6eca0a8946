// From the public bodies and scenes to what they are made of, and back.
#pragma once

#include "haptics/scene/contact_body.h"
#include "haptics/scene/moving_surface.h"
#include "proxima/touch_scene.h"

#include <memory>
#include <utility>

namespace proxima {

/// What TouchBody and TouchScene let in.
class TouchAccess {
public:
    [[nodiscard]] static TouchBody wrap(std::unique_ptr<const ContactBody> body) noexcept
    {
        return TouchBody(std::move(body));
    }
    [[nodiscard]] static std::unique_ptr<const ContactBody> unwrap(TouchBody body) noexcept
    {
        return std::move(body.body_);
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

/// \pre the body was not moved from
[[nodiscard]] inline const ContactBody& contact_body(const TouchBody& body) noexcept
{
    return TouchAccess::body(body);
}

/// The scene's surface, which stays where it is while the scene lives. A renderer of it alone would
/// not advance the scene: renderers take the scene itself. \pre the scene was not moved from
[[nodiscard]] inline MovingSurface& moving_surface(TouchScene& scene) noexcept
{
    return TouchAccess::surface(scene);
}
[[nodiscard]] inline const MovingSurface& moving_surface(const TouchScene& scene) noexcept
{
    return TouchAccess::surface(scene);
}

} // namespace proxima
