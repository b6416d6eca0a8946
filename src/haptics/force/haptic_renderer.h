// One tick of haptic rendering: from what the device says to the force that it gets.
//
//     device -> model's frame -> proxy -> spring and damper -> passivity -> ramps, clamp, slew
//
//     HapticRenderer renderer(surface, map, *find_device("omni"));
//     renderer.tick(state, 1e-3).force                       // every millisecond
//
// A scene's objects move as part of the tick: the proxy is carried along by what it touches, held
// back by what comes its way (move_with_objects.h), and damping, friction and the passivity observer go
// by the motion relative to the surface. Where a body was exchanged, or objects left the proxy no
// room, it begins anew, outside of closed bodies, and the last force fades while the new one rises
// as at a start.
//
// Bad input never reaches the force: a position that is no number keeps the last one and lets the
// force fade; a jump that no hand makes begins anew from there, with the ramp of a start.
#pragma once

#include "haptics/device/device.h"
#include "haptics/device/workspace_map.h"
#include "haptics/force/contact_force.h"
#include "haptics/force/passivity.h"
#include "haptics/force/penalty_probe.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scene/move_with_objects.h"
#include "haptics/scene/touch_scene.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/surface_feel.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace proxima {

enum class Passivity : bool { unguarded, guarded };

/// What the spring pulls towards.
enum class ForceLaw : std::uint8_t {
    proxy,  ///< a proxy that stays outside
    penalty ///< the nearest place of the surface: a baseline (penalty_probe.h)
};

struct RenderOptions {
    ForceOptions force = {};
    double proxy_radius = 0; ///< m; 0 = a point
    double static_friction = 0.4;
    double dynamic_friction = 0.3;
    Passivity passivity = Passivity::guarded;
    double max_jump = 0.05; ///< m in a tick: 50 m/s at 1 kHz
    /// Of the proxy in a tick, twice as many with shading: bounds a tick's work (proxy.h).
    std::size_t max_moves = 12;
    ForceShading shading = ForceShading::off; ///< on: by the normals of the surface's feel
    /// With penalty forces, radius, frictions, max_moves and shading say nothing.
    ForceLaw law = ForceLaw::proxy;
};

/// The proxy's part of the options, in the model's units. `feel` must outlive the proxy.
[[nodiscard]] ProxyOptions proxy_options(const RenderOptions& options, const WorkspaceMap& map,
                                         const SurfaceFeel* feel) noexcept;

/// What was wrong with a tick's input.
enum class InputFault : std::uint8_t { none, not_finite, jumped };

struct RenderTick {
    Vec3 position = Vec3::Zero(); ///< of the device, m, as used
    Vec3 force = Vec3::Zero();    ///< N, what the device gets
    Vec3 spring = Vec3::Zero();   ///< N, before the guards
    ProxyTick proxy;              ///< in the model's units
    InputFault fault = InputFault::none;
    Vec3 carrying = Vec3::Zero(); ///< m/s: the velocity of the surface that is touched
    bool squeezed = false;        ///< objects that moved left the proxy no room
    bool popped = false; ///< by penalty forces: pushed against the side it was pushed out on before
    InputCondition condition = InputCondition::well; ///< as the state said
};

/// Refers to surface, scene and feel. One thread. noexcept and without allocation but for the
/// constructor.
class HapticRenderer {
public:
    /// The options are limited to what the device can take. \pre options.law is proxy, here and of
    /// a scene
    HapticRenderer(const ContactSurface& surface, const WorkspaceMap& map,
                   const DeviceLimits& device, const RenderOptions& options = {},
                   const SurfaceFeel* feel = nullptr);

    /// By penalty forces, of which the proxy stays unused. \pre options.law is penalty
    HapticRenderer(const ContactSurface& surface, const PenaltySurface& inside,
                   const WorkspaceMap& map, const DeviceLimits& device,
                   const RenderOptions& options);

    /// Of a scene, which each tick advances, and whose objects have their own feel.
    HapticRenderer(TouchScene& scene, const WorkspaceMap& map, const DeviceLimits& device,
                   const RenderOptions& options = {});

    [[nodiscard]] const RenderOptions& options() const noexcept { return options_; }
    [[nodiscard]] const WorkspaceMap& map() const noexcept { return map_; }
    [[nodiscard]] const Proxy& proxy() const noexcept { return proxy_; }
    [[nodiscard]] const ForceGuard& guard() const noexcept { return guard_; }
    [[nodiscard]] const PassivityGuard& passivity() const noexcept { return passivity_; }

    /// The first tick with a finite position places the proxy. The force fades while the patch is
    /// lost or the state is not well. \pre seconds > 0
    const RenderTick& tick(const DeviceState& state, double seconds,
                           Patch patch = Patch::available) noexcept;

    [[nodiscard]] const RenderTick& last() const noexcept { return tick_; }

    /// Places of the last tick, straight ways between them, that nothing should be met on: the
    /// proxy's, or the probe's of penalty forces.
    [[nodiscard]] std::span<const Vec3> path() const noexcept
    {
        return probe_ ? probe_->path() : proxy_.path();
    }

private:
    HapticRenderer(const ContactSurface& surface, const WorkspaceMap& map,
                   const DeviceLimits& device, const RenderOptions& options,
                   const SurfaceFeel* feel, std::optional<PenaltyProbe> probe);
    void place(const Vec3& device) noexcept;
    [[nodiscard]] const ProxyTick& follow(const Vec3& device) noexcept;
    [[nodiscard]] Vec3 accept(const DeviceState& state) noexcept;
    void advance_scene(double seconds) noexcept;
    [[nodiscard]] std::optional<Vec3> carried(const Vec3& place) noexcept;
    void begin_anew() noexcept;
    [[nodiscard]] Vec3 surface_velocity() const noexcept;
    [[nodiscard]] Vec3 spring(const Vec3& device, const Vec3& velocity) const noexcept;

    TouchScene* scene_ = nullptr;
    const SurfaceFeel* feel_ = nullptr;
    DeviceLimits device_;
    WorkspaceMap map_;
    RenderOptions options_;
    Proxy proxy_;
    std::optional<PenaltyProbe> probe_; ///< of penalty forces
    ForceGuard guard_;
    PassivityGuard passivity_;
    RenderTick tick_;
    CarryRoom carry_room_;
    Vec3 ground_ = Vec3::Zero(); ///< m: how far the surface has carried what touches it
    bool placed_ = false;
};

} // namespace proxima
