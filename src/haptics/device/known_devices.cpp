#include "proxima/device.h"

#include <algorithm>
#include <array>

namespace proxima {

namespace {

constexpr std::array<DeviceLimits, 6> devices = {{{"touch", 3.3, 400, 4, 0.075},
                                                  {"omni", 3.3, 700, 5, 0.10},
                                                  {"desktop", 7.9, 1000, 5, 0.10},
                                                  {"falcon", 8, 3000, 20, 0.04},
                                                  {"omega", 12, 5000, 30, 0.075},
                                                  {"delta", 20, 5000, 30, 0.15}}};

} // namespace

DeviceLimits within(const DeviceLimits& limits, const DeviceLimits& other) noexcept
{
    return {limits.name,
            std::min(limits.max_force, other.max_force),
            std::min(limits.max_stiffness, other.max_stiffness),
            std::min(limits.max_damping, other.max_damping),
            std::min(limits.workspace_radius, other.workspace_radius),
            std::min(limits.max_torque, other.max_torque)};
}

std::span<const DeviceLimits> known_devices() noexcept
{
    return devices;
}

std::optional<DeviceLimits> find_device(std::string_view name) noexcept
{
    const auto* const found =
        std::find_if(devices.begin(), devices.end(),
                     [&](const DeviceLimits& each) { return each.name == name; });
    if (found == devices.end()) return std::nullopt;
    return *found;
}

} // namespace proxima
