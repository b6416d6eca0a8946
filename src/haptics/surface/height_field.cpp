#include "haptics/surface/height_field.h"

#include "base/text.h"
#include "geometry/length.h"
#include "haptics/surface/height_image.h"
#include "haptics/surface/wave.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace proxima {

namespace {

constexpr double most_turns = 0x1p52;

/// A quarter of the device's stiffness, and N/m: with more, a hand that bounces off a surface of the
/// greatest stiffness, with forces three ticks late, swings along the surface as fast as it bounces, and
/// the passivity guard does not see it. Found with simulated hands (surface_texture_test.cpp).
constexpr double most_stick_part = 0.25;
constexpr double most_stick_stiffness = 200;

/// h and its gradient by turns.
struct Height {
    double value = 1;
    Vec3 slope = Vec3::Zero();
};

Height dimples_at(const Vec3& turns) noexcept
{
    Height height{.value = 0};
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const Wave wave = wave_at(turns[axis]);
        height.value += wave.cosine / 3;
        height.slope[axis] = -2 * std::numbers::pi / 3 * wave.sine;
    }
    return height;
}

/// From -1 to 1, at random for each corner of the lattice (the finalizer of SplitMix64).
double corner_value(std::int64_t x, std::int64_t y, std::int64_t z) noexcept
{
    std::uint64_t bits = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15U;
    bits = (bits ^ static_cast<std::uint64_t>(y)) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ static_cast<std::uint64_t>(z)) * 0x94d049bb133111ebU;
    bits = (bits ^ bits >> 30U) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ bits >> 27U) * 0x94d049bb133111ebU;
    return static_cast<double>((bits ^ bits >> 31U) >> 11U) * 0x1p-52 - 1;
}

/// Values of a lattice, blended by a quintic: value noise of period 2^52 with continuous curvature.
Height noise_at(const Vec3& turns) noexcept
{
    std::array<std::int64_t, 3> cell{};
    Vec3 part;
    Vec3 rate;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        const double below = std::floor(turns[i]);
        const double t = turns[i] - below;
        cell[axis] = static_cast<std::int64_t>(below);
        part[i] = t * t * t * (t * (6 * t - 15) + 10);
        rate[i] = 30 * t * t * (t - 1) * (t - 1);
    }
    Height height{.value = 0};
    for (unsigned corner = 0; corner < 8; ++corner) {
        const std::array<std::int64_t, 3> step = {corner & 1U, corner >> 1U & 1U, corner >> 2U};
        const double value = corner_value(cell[0] + step[0], cell[1] + step[1], cell[2] + step[2]);
        Vec3 weight;
        Vec3 change;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<Eigen::Index>(axis);
            weight[i] = step[axis] != 0 ? part[i] : 1 - part[i];
            change[i] = step[axis] != 0 ? rate[i] : -rate[i];
        }
        height.value += value * weight[0] * weight[1] * weight[2];
        height.slope +=
            value * Vec3(change[0] * weight[1] * weight[2], weight[0] * change[1] * weight[2],
                         weight[0] * weight[1] * change[2]);
    }
    return height;
}

Height height_at(const Bump& bump, const Vec3& turns) noexcept
{
    switch (bump.shape) {
    case BumpShape::grating: {
        const Vec3 along = bump.direction.normalized();
        const Wave wave = wave_at(along.dot(turns));
        return {wave.cosine, -2 * std::numbers::pi * wave.sine * along};
    }
    case BumpShape::dimples:
        return dimples_at(turns);
    case BumpShape::noise:
        return noise_at(turns);
    case BumpShape::image: {
        if (!bump.image) break;
        const ImageAxes axes = image_axes(bump.direction);
        const ImageHeight image =
            height_at(bump.image->parts(), axes.right.dot(turns), axes.up.dot(turns));
        return {image.value, image.right * axes.right + image.up * axes.up};
    }
    case BumpShape::none:
        break;
    }
    return {};
}

/// The greatest slope and curvature of h where a wavelength is 1.
struct Steepness {
    double slope;
    double curvature;
};

Steepness steepness_of(const Bump& bump) noexcept
{
    // Of noise the greatest slope and the sum of a row of the Hessian, with 15/8 and 10/sqrt(3) those
    // of the quintic; of waves 2 pi and its square, for dimples are three of a third.
    constexpr double turn = 2 * std::numbers::pi;
    if (bump.shape == BumpShape::noise) return {6.5, 39.7};
    if (bump.shape != BumpShape::image) return {turn, turn * turn};
    if (!bump.image) return {0, 0};
    return {bump.image->parts().slope(), bump.image->parts().curvature()};
}

struct Range {
    const char* name;
    double value;
    double least;
    double most;
};

} // namespace

Groove groove_at(const Bump& bump, double amplitude, const Vec3& position) noexcept
{
    const Vec3 turns = position / bump.wavelength;
    if (bump.shape == BumpShape::none || !(amplitude > 0) || !(turns.norm() < most_turns))
        return {};
    const Height height = height_at(bump, turns);
    return {amplitude * std::max(1 - height.value, 0.0),
            -amplitude / bump.wavelength * height.slope};
}

Groove groove_at(const Bump& bump, const Vec3& position) noexcept
{
    return groove_at(bump, bump.amplitude, position);
}

double most_amplitude(const Bump& bump, double stiffness, const DeviceLimits& device) noexcept
{
    const Steepness steepest = steepness_of(bump);
    if (!(steepest.curvature > 0)) return std::numeric_limits<double>::infinity(); // it is flat
    const double slope = steepest.slope / bump.wavelength;
    const double curvature = steepest.curvature / (bump.wavelength * bump.wavelength);
    const double push = device.max_force * curvature;
    const double root =
        std::sqrt(push * push + 4 * stiffness * slope * slope * device.max_stiffness);
    const double stable = push > 0 ? 2 * device.max_stiffness / (push + root) : 0;
    return std::min(stable, 1 / slope);
}

TextureStrengths limited_strengths(const SurfaceTexture& texture, double stiffness,
                                   const DeviceLimits& device) noexcept
{
    TextureStrengths strengths;
    strengths.amplitude = texture.bump.amplitude;
    if (texture.bump.any()) {
        strengths.amplitude =
            std::min(strengths.amplitude, most_amplitude(texture.bump, stiffness, device));
    }
    strengths.viscosity = std::min(texture.viscosity, most_texture_damping(device));
    strengths.stick_slip = {
        .stiffness = std::min({texture.stick_slip.stiffness, most_stick_part * device.max_stiffness,
                               most_stick_stiffness}),
        .max_force = std::min(texture.stick_slip.max_force, device.max_force)};
    strengths.tap = texture.tap;
    strengths.tap.gain = std::min(texture.tap.gain, most_tap_gain);
    return strengths;
}

SurfaceTexture limited(SurfaceTexture texture, double stiffness,
                       const DeviceLimits& device) noexcept
{
    const TextureStrengths strengths = limited_strengths(texture, stiffness, device);
    texture.bump.amplitude = strengths.amplitude;
    texture.viscosity = strengths.viscosity;
    texture.stick_slip = strengths.stick_slip;
    texture.tap = strengths.tap;
    return texture;
}

Status check_texture(const SurfaceTexture& texture)
{
    constexpr double strong = 1e9;
    const Bump& bump = texture.bump;
    const double length = length_of(bump.direction);
    const std::array<Range, 9> ranges = {
        {{"bump amplitude", bump.amplitude, 0, 0.01},
         {"bump wavelength", bump.wavelength, 1e-4, 1},
         {"length of the bump direction", length, 1e-100, 1e100},
         {"viscosity", texture.viscosity, 0, strong},
         {"stick-slip stiffness", texture.stick_slip.stiffness, 0, strong},
         {"stick-slip max_force", texture.stick_slip.max_force, 0, strong},
         {"tap gain", texture.tap.gain, 0, strong},
         {"tap frequency", texture.tap.frequency, 10, 400},
         {"tap decay", texture.tap.decay, 10, 1000}}};
    for (const Range& range : ranges) {
        if (range.value >= range.least && range.value <= range.most) continue;
        return fail(ErrorCode::invalid_argument,
                    concat("the ", range.name, " of a texture is ", range.value, " and must be ",
                           range.least, " to ", range.most),
                    "texture");
    }
    if (bump.shape == BumpShape::image && !bump.image) {
        return fail(ErrorCode::invalid_argument,
                    "the bump of a texture is an image and has none: give one, or another shape",
                    "texture");
    }
    return {};
}

} // namespace proxima
