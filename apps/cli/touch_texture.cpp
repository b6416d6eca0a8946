#include "cli/touch_texture.h"

#include "base/text.h"
#include "cli/names.h"
#include "haptics/surface/height_field.h"

#include <array>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::pair<std::string_view, BumpShape>, 3> bump_names = {
    {{"grating", BumpShape::grating},
     {"dimples", BumpShape::dimples},
     {"noise", BumpShape::noise}}};

std::string_view name_of(BumpShape shape) noexcept
{
    for (const auto& [name, known] : bump_names)
        if (known == shape) return name;
    return "none";
}

/// Whether the numbers are as many as the effect takes, which they are then given to.
bool give(SurfaceTexture& texture, std::string_view name, const std::vector<double>& numbers)
{
    const std::size_t count = numbers.size();
    for (const auto& [bump, shape] : bump_names) {
        if (name != bump) continue;
        const bool directed = shape == BumpShape::grating && count == 5;
        if (count != 2 && !directed) return false;
        texture.bump = {.shape = shape, .amplitude = numbers[0], .wavelength = numbers[1]};
        if (directed) texture.bump.direction = Vec3(numbers[2], numbers[3], numbers[4]);
        return true;
    }
    if (name == "viscosity" && count == 1) {
        texture.viscosity = numbers[0];
        return true;
    }
    if (name == "stick-slip" && count == 2) {
        texture.stick_slip = {.stiffness = numbers[0], .max_force = numbers[1]};
        return true;
    }
    if (name == "tap" && (count == 1 || count == 3)) {
        texture.tap.gain = numbers[0];
        if (count == 3) texture.tap.frequency = numbers[1];
        if (count == 3) texture.tap.decay = numbers[2];
        return true;
    }
    return false;
}

} // namespace

bool is_of_object(std::string_view text) noexcept
{
    return text.find('=') != std::string_view::npos;
}

Result<SurfaceTexture> with_effect(const SurfaceTexture& texture, std::string_view text)
{
    SurfaceTexture result = texture;
    const std::size_t colon = text.find(':');
    const auto numbers = colon == std::string_view::npos
                             ? std::nullopt
                             : parse_finite_numbers(text.substr(colon + 1));
    if (!numbers || !give(result, text.substr(0, colon), *numbers)) {
        return fail(ErrorCode::invalid_argument,
                    concat("'", text, "' is no texture: give ", texture_forms));
    }
    if (const Status status = check_texture(result); !status)
        return fail(status.error().code, concat("'", text, "': ", status.error().message));
    return result;
}

SurfaceTexture common_texture(std::span<const std::string> texts)
{
    SurfaceTexture texture;
    for (const std::string& text : texts)
        if (!is_of_object(text)) texture = *with_effect(texture, text);
    return texture;
}

std::string texture_text(const SurfaceTexture& texture, const TextureReport& report)
{
    if (!texture.any() && report.taps + report.slips + report.damped_ticks == 0) return {};
    std::string text = "texture:";
    if (texture.bump.any()) {
        text += fmt::format(" {} of {:g} mm every {:g} mm;", name_of(texture.bump.shape),
                            1e3 * texture.bump.amplitude, 1e3 * texture.bump.wavelength);
    }
    text += fmt::format(" {} slips, {} taps, at most {:.3f} mJ given by one, damped in {} ticks\n",
                        report.slips, report.taps, 1e3 * report.given, report.damped_ticks);
    return text;
}

Json texture_json(const SurfaceTexture& texture)
{
    if (!texture.any()) return nullptr;
    const Bump& bump = texture.bump;
    return {{"bump", name_of(bump.shape)},
            {"amplitude", bump.amplitude},
            {"wavelength", bump.wavelength},
            {"direction", {bump.direction.x(), bump.direction.y(), bump.direction.z()}},
            {"viscosity", texture.viscosity},
            {"stick_slip_stiffness", texture.stick_slip.stiffness},
            {"stick_slip_max_force", texture.stick_slip.max_force},
            {"tap_gain", texture.tap.gain},
            {"tap_frequency", texture.tap.frequency},
            {"tap_decay", texture.tap.decay}};
}

Json texture_json(const TextureReport& report)
{
    return {{"slips", report.slips},
            {"taps", report.taps},
            {"most_given", report.given},
            {"damped_ticks", report.damped_ticks}};
}

} // namespace proxima
