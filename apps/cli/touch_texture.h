// The textures that --texture gives to all that is touched, or to an object by its number.
#pragma once

#include "haptics/force/surface_texture.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace proxima {

/// The forms of a value, for help and messages.
inline constexpr std::string_view texture_forms =
    "grating:A,L[,DX,DY,DZ], dimples:A,L, noise:A,L (amplitude and wavelength in m), viscosity:B "
    "(N s/m), stick-slip:K,F (N/m, N) or tap:G[,HZ,DECAY] (N s/m, Hz, 1/s)";

/// Whether a value is of an object by its number, "N=...".
[[nodiscard]] bool is_of_object(std::string_view text) noexcept;

/// The texture with the effect of a value, without its "N=". Error invalid_argument: no such effect,
/// or a number out of range.
[[nodiscard]] Result<SurfaceTexture> with_effect(const SurfaceTexture& texture,
                                                 std::string_view text);

/// What the values without a number give to all that is touched. \pre with_effect() takes them
[[nodiscard]] SurfaceTexture common_texture(std::span<const std::string> texts);

/// A line on what textures did; "" for none.
[[nodiscard]] std::string texture_text(const SurfaceTexture& texture, const TextureReport& report);

[[nodiscard]] nlohmann::ordered_json texture_json(const SurfaceTexture& texture);
[[nodiscard]] nlohmann::ordered_json texture_json(const TextureReport& report);

} // namespace proxima
