// What a haptic device can take, and what it says every tick.
//
//     position, rotation, velocity, buttons   up, 1,000 times a second
//     force                                   down, within the limits of the device
//
// Metres, newtons, seconds.
#pragma once

#include "proxima/geometry/rigid_transform.h"
#include "proxima/geometry/vec.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace proxima {

/// Limits of a device, from its maker.
struct DeviceLimits {
    std::string_view name;
    double max_force = 3.3;          ///< N
    double max_stiffness = 400;      ///< N/m
    double max_damping = 4;          ///< N s/m
    double workspace_radius = 0.075; ///< m: of a ball that can be reached
};

/// The devices whose limits are known: touch, omni (the thesis's), desktop, falcon, omega, delta.
[[nodiscard]] std::span<const DeviceLimits> known_devices() noexcept;

/// By name.
[[nodiscard]] std::optional<DeviceLimits> find_device(std::string_view name) noexcept;

/// What a device says: its tip and how it is held.
struct DeviceState {
    RigidTransform pose;          ///< of the tip; metres
    Vec3 velocity = Vec3::Zero(); ///< of the tip, m/s, as the device says or from differences
    std::uint32_t buttons = 0;    ///< a bit each
};

} // namespace proxima
