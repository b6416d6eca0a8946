// The guards of a tool's force and torque, in the order of points (surface_renderer.h).
//
//     while ramps rise    RampObserver, one for each    damps what a spring would give that becomes stiffer
//     in contact          ToolPassivity, for both       damps swings, then softens
//     always              ForceGuard, one for each      ramps, limit, slew limit
#pragma once

#include "haptics/force/carried_frame.h"
#include "haptics/force/contact_force.h"
#include "haptics/force/passivity.h"
#include "haptics/force/ramp_observer.h"
#include "haptics/tool/rigid_motion.h"
#include "haptics/tool/tool_passivity.h"
#include "proxima/device.h"
#include "proxima/geometry.h"
#include "proxima/tool_renderer.h"

#include <optional>

namespace proxima {

/// Force, N, and torque, N m.
struct Wrench {
    Vec3 force = Vec3::Zero();
    Vec3 torque = Vec3::Zero();
};

/// A tick of the springs.
struct ToolPull {
    Twist travel;                ///< of the device since the tick before, m and rad
    std::optional<Twist> ground; ///< of what is touched, where it can move
    double ground_seconds =
        0;         ///< in which it moved so far; a tick, more after ticks that were lost
    Wrench spring; ///< without damping
    Wrench whole;
    bool jumped = false; ///< the device: the force ramps up anew
};

/// One per tool. noexcept, no allocation, O(1).
class ToolGuard {
public:
    /// \pre the options are limited to what the device can take
    ToolGuard(const ToolRenderOptions& options, const DeviceLimits& device);

    /// What the device gets; zero for a force or torque that is not finite. \pre travel is finite,
    /// seconds > 0
    [[nodiscard]] Wrench pass(const ToolPull& pull, double seconds, Patch patch) noexcept;

    /// As new.
    void reset() noexcept;

    /// Like ForceGuard::ramp().
    [[nodiscard]] double ramp() const noexcept { return force_.ramp(); }
    [[nodiscard]] const ToolPassivity& passivity() const noexcept { return passivity_; }

private:
    [[nodiscard]] Wrench guarded(const ToolPull& pull, double seconds) noexcept;

    Guard mode_;
    bool gives_torque_;
    ForceGuard force_;
    ForceGuard torque_;
    RampObserver force_ramp_;
    RampObserver torque_ramp_;
    ToolPassivity passivity_;
    CarriedFrame<6> frame_;
    Vec6 position_ = Vec6::Zero(); ///< all travel in the frame, at the lever
    Vec6 relative_ = Vec6::Zero(); ///< relative to what is touched
};

/// The guards of a tool, for tests and reports. \pre the renderer was not moved from
[[nodiscard]] const ToolGuard& guard_of(const ToolRenderer& renderer) noexcept;

} // namespace proxima
