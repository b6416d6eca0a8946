// The material of an object on its way from one to another: each number changes evenly.
#pragma once

#include "proxima/touch_scene.h"

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

/// A material that the application gave an object.
struct GivenMaterial {
    SurfaceMaterial material;
    double seconds = 0;          ///< until the object has it
    std::uint64_t exchanges = 0; ///< of the object's body until then
};

/// Of one object, by the servo thread. noexcept, no allocation.
class MaterialChange {
public:
    /// Begins a change. `body` is the material of the object's body.
    void begin(const GivenMaterial& given, const std::optional<SurfaceMaterial>& body) noexcept
    {
        const std::optional<SurfaceMaterial> present = at(given.exchanges);
        from_ = present ? *present : body.value_or(given.material);
        given_ = given;
        passed_ = 0;
        part_ = given.seconds > 0 ? 0 : 1;
        has_given_ = true;
    }

    /// Advances by a tick. \pre seconds > 0
    void advance(double seconds) noexcept
    {
        if (!(part_ < 1)) return;
        passed_ += seconds;
        // The sum of ticks may be less than the wanted time by a few roundings.
        const double whole = given_.seconds * (1 - 1e-9);
        part_ = passed_ < whole ? passed_ / given_.seconds : 1;
    }

    /// The material of this tick; nothing where the body's own counts: none was given since the body
    /// was exchanged.
    [[nodiscard]] std::optional<SurfaceMaterial> at(std::uint64_t exchanges) const noexcept
    {
        if (!has_given_ || given_.exchanges != exchanges) return std::nullopt;
        const auto between = [&](double from, double to) {
            return part_ < 1 ? from + part_ * (to - from) : to;
        };
        const SurfaceMaterial& to = given_.material;
        return SurfaceMaterial{
            .stiffness = between(from_.stiffness, to.stiffness),
            .damping = between(from_.damping, to.damping),
            .static_friction = between(from_.static_friction, to.static_friction),
            .dynamic_friction = between(from_.dynamic_friction, to.dynamic_friction)};
    }

private:
    GivenMaterial given_;
    SurfaceMaterial from_;
    double passed_ = 0; ///< s since the change began
    double part_ = 1;
    bool has_given_ = false;
};

} // namespace proxima
