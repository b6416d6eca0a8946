// What a HapticRenderer (haptic_renderer.h) is made of: proxy, spring, passivity and force guards,
// and how a tick goes through them.
//
// A scene's objects move as part of the tick: the proxy is carried along by what it touches, held
// back by what comes its way (move_with_objects.h), and damping, friction and the passivity
// observer go by the motion relative to the surface. Where a body was exchanged, or objects left
// the proxy no room, it begins anew, outside of closed bodies, and the last force fades while the
// new one rises as at a start.
#pragma once

#include "haptics/force/contact_force.h"
#include "haptics/force/passivity.h"
#include "haptics/force/penalty_probe.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scene/move_with_objects.h"
#include "haptics/scene/moving_surface.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/surface_feel.h"
#include "proxima/device.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"

#include <memory>
#include <optional>
#include <span>

namespace proxima {

/// The proxy's part of the options, in the model's units. `feel` must outlive the proxy.
[[nodiscard]] ProxyOptions proxy_options(const RenderOptions& options, const WorkspaceMap& map,
                                         const SurfaceFeel* feel) noexcept;

/// What a renderer touches. All but `surface` may be null.
struct RenderedSurface {
    const ContactSurface* surface = nullptr;
    const SurfaceFeel* feel = nullptr;
    MovingSurface* scene = nullptr; ///< the same as surface and feel, where each tick advances it
    std::unique_ptr<const ContactSurface> owned = nullptr; ///< the same as surface, kept alive
};

/// Refers to surface, scene and feel. One thread. noexcept and without allocation but for the
/// constructor.
class SurfaceRenderer {
public:
    /// The options are limited to what the device can take. \pre there is a probe if and only if
    /// options.law is penalty; the proxy is then unused
    SurfaceRenderer(RenderedSurface rendered, const WorkspaceMap& map, const DeviceLimits& device,
                    const RenderOptions& options, std::optional<PenaltyProbe> probe = std::nullopt);

    [[nodiscard]] const RenderOptions& options() const noexcept { return options_; }
    [[nodiscard]] const WorkspaceMap& map() const noexcept { return map_; }
    [[nodiscard]] const Proxy& proxy() const noexcept { return proxy_; }
    [[nodiscard]] const ForceGuard& guard() const noexcept { return guard_; }
    [[nodiscard]] const PassivityGuard& passivity() const noexcept { return passivity_; }

    /// As HapticRenderer::tick().
    const RenderTick& tick(const DeviceState& state, double seconds, Patch patch) noexcept;

    [[nodiscard]] const RenderTick& last() const noexcept { return tick_; }

    /// Of the last tick: what the proxy, or the probe of penalty forces, answered.
    [[nodiscard]] const ProxyTick& proxy_tick() const noexcept
    {
        return probe_ ? probe_->last() : proxy_.last();
    }

    /// Places of the last tick, straight ways between them, that nothing should be met on: the
    /// proxy's, or the probe's of penalty forces.
    [[nodiscard]] std::span<const Vec3> path() const noexcept
    {
        return probe_ ? probe_->path() : proxy_.path();
    }

private:
    void place(const Vec3& device) noexcept;
    [[nodiscard]] const ProxyTick& follow(const Vec3& device) noexcept;
    void write_proxy(const ProxyTick& proxy) noexcept;
    [[nodiscard]] Vec3 accept(const DeviceState& state) noexcept;
    void advance_scene(double seconds) noexcept;
    [[nodiscard]] std::optional<Vec3> carried(const Vec3& place) noexcept;
    void begin_anew() noexcept;
    [[nodiscard]] Vec3 surface_velocity(const ProxyTick& proxy) const noexcept;
    [[nodiscard]] Vec3 spring(const ProxyTick& proxy, const Vec3& device,
                              const Vec3& velocity) const noexcept;

    std::unique_ptr<const ContactSurface> owned_;
    MovingSurface* scene_ = nullptr;
    const SurfaceFeel* feel_ = nullptr;
    DeviceLimits device_;
    WorkspaceMap map_;
    RenderOptions options_;
    Proxy proxy_;
    std::optional<PenaltyProbe> probe_; ///< of penalty forces
    ForceGuard guard_;
    PassivityGuard passivity_;
    RenderTick tick_;
    CarryScratch carry_scratch_;
    Vec3 ground_ = Vec3::Zero(); ///< m: how far the surface has carried what touches it
    bool placed_ = false;
};

/// What HapticRenderer lets in.
class RendererAccess {
public:
    [[nodiscard]] static HapticRenderer wrap(std::unique_ptr<SurfaceRenderer> renderer) noexcept
    {
        return HapticRenderer(std::move(renderer));
    }
    [[nodiscard]] static const SurfaceRenderer& parts(const HapticRenderer& renderer) noexcept
    {
        return *renderer.renderer_;
    }
};

/// The renderer's proxy, guards and last slide: for tests, and for programs that report them.
/// \pre the renderer was not moved from
[[nodiscard]] inline const SurfaceRenderer& parts_of(const HapticRenderer& renderer) noexcept
{
    return RendererAccess::parts(renderer);
}

/// A renderer of penalty forces. Refers to surface and inside. \pre options.law is penalty
[[nodiscard]] HapticRenderer make_penalty_renderer(const ContactSurface& surface,
                                                   const PenaltySurface& inside,
                                                   const WorkspaceMap& map,
                                                   const DeviceLimits& device,
                                                   const RenderOptions& options);

} // namespace proxima
