// The material of an object on its way from one to another: each number changes evenly.
#pragma once

#include "haptics/scene/scene_clock.h"
#include "proxima/touch_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace proxima {

/// What is_valid() tells.
inline constexpr const char* material_rule =
    "stiffness, damping and friction of a surface must be finite and not negative, and dynamic "
    "friction at most static friction";

[[nodiscard]] inline bool is_valid(const SurfaceMaterial& material) noexcept
{
    for (const double number : {material.stiffness, material.damping, material.static_friction,
                                material.dynamic_friction}) {
        if (!(number >= 0) || !std::isfinite(number)) return false;
    }
    return material.dynamic_friction <= material.static_friction;
}

/// A change of an object's material that began at a time of the scene, so all tools see the same
/// numbers. A value; noexcept, no allocation.
class MaterialCourse {
public:
    /// None was given.
    MaterialCourse() = default;

    /// The course that leaves this one at a time. `body` is the material of the object's body, which
    /// has been exchanged so often.
    [[nodiscard]] MaterialCourse continued(const SurfaceMaterial& material, double seconds,
                                           const std::optional<SurfaceMaterial>& body,
                                           std::uint64_t exchanges, SceneTime start) const noexcept
    {
        const std::optional<SurfaceMaterial> present = at(exchanges, start);
        MaterialCourse next;
        next.from_ = present ? *present : body.value_or(material);
        next.to_ = material;
        next.seconds_ = seconds;
        next.exchanges_ = exchanges;
        next.start_ = start;
        next.is_given_ = true;
        return next;
    }

    /// The material of an object whose body was exchanged so often; nothing where the body's own
    /// counts: none was given since the body was exchanged.
    [[nodiscard]] std::optional<SurfaceMaterial> at(std::uint64_t exchanges,
                                                    SceneTime time) const noexcept
    {
        if (!is_given_ || exchanges_ != exchanges) return std::nullopt;
        const double passed = std::max(0.0, seconds_between(start_, time));
        // Half a nanosecond per tick is lost in the scene's time.
        if (passed >= seconds_ * (1 - 1e-9)) return to_;
        const double part = passed / seconds_;
        const auto between = [part](double from, double to) { return from + part * (to - from); };
        return SurfaceMaterial{
            .stiffness = between(from_.stiffness, to_.stiffness),
            .damping = between(from_.damping, to_.damping),
            .static_friction = between(from_.static_friction, to_.static_friction),
            .dynamic_friction = between(from_.dynamic_friction, to_.dynamic_friction)};
    }

private:
    SurfaceMaterial from_;
    SurfaceMaterial to_;
    double seconds_ = 0;          ///< of the change
    std::uint64_t exchanges_ = 0; ///< of the object's body when it was given
    SceneTime start_ = 0;
    bool is_given_ = false;
};

} // namespace proxima
