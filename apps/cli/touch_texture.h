// The textures that --texture gives to all that is touched, or to an object by its number.
#pragma once

#include "haptics/force/surface_texture.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"

#include <cstddef>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace proxima {

/// The forms of a value, for help and messages.
inline constexpr std::string_view texture_forms =
    "grating:A,L[,DX,DY,DZ], dimples:A,L, noise:A,L (amplitude and wavelength in m), "
    "image:FILE,A,L[,DX,DY,DZ] (a grey PNG or .npy, L wide), viscosity:B (N s/m), stick-slip:K,F "
    "(N/m, N) or tap:G[,HZ,DECAY] (N s/m, Hz, 1/s)";

/// The images that values name, by their files.
using TextureImages = std::map<std::string, HeightImage>;

/// Whether a value is of an object by its number, "N=...".
[[nodiscard]] bool is_of_object(std::string_view text) noexcept;

/// Whether a value, without its "N=", is an effect whose numbers are in range. Reads no file. Error
/// invalid_argument.
[[nodiscard]] Status check_effect(std::string_view text);

/// Whether no effect comes in place of an earlier one of the same values, of all or of one object.
/// \pre check_effect() takes them. Error invalid_argument.
[[nodiscard]] Status check_effects_differ(std::span<const std::string> texts);

/// Reads each image once that the values name. \pre check_effect() takes them. Errors: those of
/// read_height_image.
[[nodiscard]] Result<TextureImages> read_texture_images(std::span<const std::string> texts,
                                                        Progress* progress);

/// The texture with the effect of a value, without its "N=". \pre check_effect() takes it, and its
/// image is there
[[nodiscard]] SurfaceTexture with_effect(const SurfaceTexture& texture, std::string_view text,
                                         const TextureImages& images);

/// What the values without a number give to all that is touched. \pre as with_effect
[[nodiscard]] SurfaceTexture common_texture(std::span<const std::string> texts,
                                            const TextureImages& images);

/// A line on what textures did; "" for none.
[[nodiscard]] std::string texture_text(const SurfaceTexture& texture, const TextureReport& report);

[[nodiscard]] nlohmann::ordered_json texture_json(const SurfaceTexture& texture);
[[nodiscard]] nlohmann::ordered_json texture_json(const TextureReport& report);

} // namespace proxima
