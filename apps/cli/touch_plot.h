// The course of a session of touching, tick by tick: as a plot or as a table.
//
//     force, N        the size of the force that the device got
//     depth, mm       of the device below the surface
//     share           of the force that ramps and the passivity guard let through, 0 to 1
//     a band below    what held the proxy, and where the input was not well
#pragma once

#include "haptics/force/surface_renderer.h"
#include "proxima/device.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"
#include "proxima/result.h"

#include <string>
#include <vector>

namespace proxima {

/// One tick, in the device's metres.
struct TracedTick {
    Vec3 position = Vec3::Zero(); ///< of the device as it was used
    Vec3 force = Vec3::Zero();    ///< N
    double depth = 0;             ///< m, below the position of a frictionless proxy
    float share = 1;              ///< of the force that ramps and the passivity guard let through
    Hold hold = Hold::free;
    InputCondition condition = InputCondition::well;
};

/// The tick that the renderer has just made. noexcept, no allocation.
[[nodiscard]] TracedTick traced(const HapticRenderer& renderer) noexcept;

struct TouchTrace {
    double tick_seconds = 1e-3;
    std::vector<TracedTick> ticks = {};
};

/// By extension: .png, .svg or .pdf, a plot with the title and the note below it; .csv, a row for each
/// tick. Errors: those of write_plot. \pre there is a tick
[[nodiscard]] Status write_touch_plot(const TouchTrace& trace, const std::string& title,
                                      const std::string& note, const std::string& path,
                                      Progress* progress = nullptr);

} // namespace proxima
