// Height fields of textured surfaces (Bump in touch_scene.h): grooves below the triangles.
//
//     crest  ___     ___        h = 1      the triangles themselves
//               \   /                      g = A (1 - h), the depth of the groove, 0 to 2 A
//     groove     \_/            h = -1
//
// Grooves are a function of the position in the object alone, and twice differentiable: so the force
// of a texture has a potential.
#pragma once

#include "proxima/device.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"

namespace proxima {

/// Depth of a groove and how it changes with the position.
struct Groove {
    double depth = 0;          ///< m
    Vec3 slope = Vec3::Zero(); ///< gradient of the depth
};

/// The groove at a position of the object's frame, in metres. None for positions whose phase is not
/// known any more, beyond 2^52 wavelengths. noexcept, O(1).
[[nodiscard]] Groove groove_at(const Bump& bump, const Vec3& position) noexcept;

/// Like groove_at(bump, position), of another amplitude than the bump's.
[[nodiscard]] Groove groove_at(const Bump& bump, double amplitude, const Vec3& position) noexcept;

/// The largest amplitude, m, at which grooves are no steeper than 45 degrees and add no more than
/// max_stiffness across the surface to a force of max_force: K s^2 A^2 + F c A <= max_stiffness, with
/// s and c the greatest slope and curvature of h. Infinite for an image that is flat.
[[nodiscard]] double most_amplitude(const Bump& bump, double stiffness,
                                    const DeviceLimits& device) noexcept;

/// N s/m along the surface: the rest of what a device takes is left to the passivity guard, for damping
/// that is late swings by itself ([colgate-1997]).
[[nodiscard]] inline double most_texture_damping(const DeviceLimits& device) noexcept
{
    return 0.25 * device.max_damping;
}

/// The numbers of a texture that a device's limits bound.
struct TextureStrengths {
    double amplitude = 0; ///< m
    double viscosity = 0; ///< N s/m
    StickSlip stick_slip;
    Tap tap;
};

/// They within a device's limits, on a surface of a stiffness. For ticks: unlike limited() it copies no
/// image. noexcept, O(1).
[[nodiscard]] TextureStrengths limited_strengths(const SurfaceTexture& texture, double stiffness,
                                                 const DeviceLimits& device) noexcept;

/// The texture within a device's limits, on a surface of a stiffness. noexcept, O(1).
[[nodiscard]] SurfaceTexture limited(SurfaceTexture texture, double stiffness,
                                     const DeviceLimits& device) noexcept;

/// Error invalid_argument, naming the number that is out of range.
[[nodiscard]] Status check_texture(const SurfaceTexture& texture);

} // namespace proxima
