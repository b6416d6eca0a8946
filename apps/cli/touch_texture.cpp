#include "cli/touch_texture.h"

#include "base/text.h"
#include "cli/height_image_file.h"
#include "cli/names.h"
#include "haptics/surface/height_field.h"

#include <algorithm>
#include <array>
#include <fmt/core.h>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

using BumpName = std::pair<std::string_view, BumpShape>;
constexpr std::array<BumpName, 4> bump_names = {{{"grating", BumpShape::grating},
                                                 {"dimples", BumpShape::dimples},
                                                 {"noise", BumpShape::noise},
                                                 {"image", BumpShape::image}}};

std::string_view name_of(BumpShape shape) noexcept
{
    for (const auto& [name, known] : bump_names)
        if (known == shape) return name;
    return "none";
}

/// What a value says, "name:file,numbers".
struct EffectText {
    std::string_view name;
    std::string file; ///< of an image; else empty
    std::vector<double> numbers;
};

constexpr std::size_t numbers_of_image = 2;
constexpr std::size_t numbers_of_directed_image = 5;

/// The file of an image may have commas in its name: the last two or five parts are the numbers.
std::optional<EffectText> split_image(std::string_view text)
{
    for (const std::size_t count : {numbers_of_directed_image, numbers_of_image}) {
        std::size_t end = text.size();
        for (std::size_t i = 0; i < count && end != std::string_view::npos; ++i)
            end = end == 0 ? std::string_view::npos : text.rfind(',', end - 1);
        if (end == std::string_view::npos || end == 0) continue;
        auto numbers = parse_finite_numbers(text.substr(end + 1));
        if (!numbers) continue;
        return EffectText{"image", std::string(text.substr(0, end)), std::move(*numbers)};
    }
    return std::nullopt;
}

std::optional<EffectText> split_effect(std::string_view text)
{
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos) return std::nullopt;
    const std::string_view name = text.substr(0, colon);
    if (name == "image") return split_image(text.substr(colon + 1));
    auto numbers = parse_finite_numbers(text.substr(colon + 1));
    if (!numbers) return std::nullopt;
    return EffectText{name, {}, std::move(*numbers)};
}

/// The effect of a value without the "N=" that it may begin with.
std::string_view effect_of(std::string_view text) noexcept
{
    return is_of_object(text) ? text.substr(text.find('=') + 1) : text;
}

/// Whether the numbers are as many as the effect takes, which they are then given to.
bool give(SurfaceTexture& texture, const EffectText& effect)
{
    const std::vector<double>& numbers = effect.numbers;
    const std::string_view name = effect.name;
    const std::size_t count = numbers.size();
    for (const auto& [bump, shape] : bump_names) {
        if (name != bump) continue;
        const bool can_be_directed = shape == BumpShape::grating || shape == BumpShape::image;
        const bool directed = can_be_directed && count == 5;
        if (count != 2 && !directed) return false;
        texture.bump = {.shape = shape, .amplitude = numbers[0], .wavelength = numbers[1]};
        if (shape == BumpShape::image) texture.bump.direction = Vec3::UnitZ();
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

/// "noise", "image, 64 x 48,"
std::string shape_text(const Bump& bump)
{
    if (!bump.image) return std::string(name_of(bump.shape));
    return fmt::format("{}, {} x {},", name_of(bump.shape), bump.image->columns(),
                       bump.image->rows());
}

Json image_json(const Bump& bump)
{
    if (bump.shape != BumpShape::image || !bump.image) return nullptr;
    return {bump.image->columns(), bump.image->rows()};
}

} // namespace

bool is_of_object(std::string_view text) noexcept
{
    return text.substr(0, text.find(':')).find('=') != std::string_view::npos;
}

Status check_effect(std::string_view text)
{
    SurfaceTexture texture;
    const auto effect = split_effect(text);
    if (!effect || !give(texture, *effect)) {
        return fail(ErrorCode::invalid_argument,
                    concat("'", text, "' is no texture: give ", texture_forms));
    }
    if (texture.bump.shape == BumpShape::image)
        texture.bump.image = *build_height_image(std::array{1.0F}, 1); // for the file's
    if (const Status status = check_texture(texture); !status)
        return fail(status.error().code, concat("'", text, "': ", status.error().message));
    return {};
}

Status check_effects_differ(std::span<const std::string> texts)
{
    std::map<std::pair<std::string_view, std::string_view>, std::string_view> first;
    for (const std::string_view text : texts) {
        const std::string_view effect = effect_of(text);
        const std::string_view name = effect.substr(0, effect.find(':'));
        const bool is_bump =
            std::ranges::find(bump_names, name, &BumpName::first) != bump_names.end();
        const std::string_view object = text.substr(0, text.size() - effect.size());
        const auto [earlier, is_new] =
            first.emplace(std::pair(object, is_bump ? "bump" : name), text);
        if (!is_new) {
            return fail(
                ErrorCode::invalid_argument,
                concat("'", text, "' would take the place of '", earlier->second,
                       "': a surface has one of grating, dimples, noise and image, and one of "
                       "each other effect"),
                "--texture");
        }
    }
    return {};
}

Result<TextureImages> read_texture_images(std::span<const std::string> texts, Progress* progress)
{
    TextureImages images;
    for (const std::string& text : texts) {
        const EffectText effect = *split_effect(effect_of(text));
        if (effect.file.empty() || images.contains(effect.file)) continue;
        auto image = read_height_image(effect.file, progress);
        if (!image) return tl::unexpected(image.error());
        images.emplace(effect.file, *image);
    }
    return images;
}

SurfaceTexture with_effect(const SurfaceTexture& texture, std::string_view text,
                           const TextureImages& images)
{
    SurfaceTexture result = texture;
    const EffectText effect = *split_effect(text);
    give(result, effect);
    if (!effect.file.empty()) result.bump.image = images.at(effect.file);
    return result;
}

SurfaceTexture common_texture(std::span<const std::string> texts, const TextureImages& images)
{
    SurfaceTexture texture;
    for (const std::string& text : texts)
        if (!is_of_object(text)) texture = with_effect(texture, text, images);
    return texture;
}

std::string texture_text(const SurfaceTexture& texture, const TextureReport& report)
{
    if (!texture.any() && report.taps + report.slips + report.damped_ticks == 0) return {};
    std::string text = "texture:";
    if (texture.bump.any()) {
        text += fmt::format(" {} of {:g} mm every {:g} mm;", shape_text(texture.bump),
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
            {"image", image_json(bump)},
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
