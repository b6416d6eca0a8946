// What patches of the collision loop miss at a speed of the hand (thesis section 5.1.1).
#pragma once

#include "cli/touch_patches.h"
#include "cli/touch_session.h"
#include "proxima/haptic_renderer.h"

#include <array>
#include <cstdint>
#include <string_view>

namespace proxima {

/// The simulated hand's scripts along which patches are tried.
inline constexpr std::array<std::string_view, 6> patch_scripts = {"press",  "slide", "stroke",
                                                                  "corner", "poke",  "walk"};

struct PatchSpeedOptions {
    double speed = 0.1;         ///< m/s
    std::uint64_t ticks = 1000; ///< of each script, 1 ms each
    double radius = 0;          ///< m, of the proxy
};

/// A device goes along all scripts at one speed, and touches patches that come a period of the
/// collision loop (100 Hz) after they were begun; beside it a proxy touches the whole model. The
/// account is the sum over the scripts.
[[nodiscard]] PatchAccount touch_at_speed(const TouchModel& model, const WorkspaceMap& map,
                                          const PatchSettings& settings,
                                          const PatchSpeedOptions& options);

} // namespace proxima
