// The implementation of HapticRenderer (haptic_renderer.h): proxy, spring, passivity and force
// guards, and the tick that goes through them.
//
// A proxy begins outside of closed bodies. Where one contains the device nothing is felt until the
// device has left it.
//
// A scene's objects move as part of the tick: touched objects carry the proxy, others push it
// (move_with_objects.h), and damping, friction and the passivity guard use the motion relative to
// the surface. Where a body that it touches, or that comes to where it is, was exchanged, or objects
// left the proxy no free position, it starts anew, outside of closed bodies, and the last force fades
// while the new one ramps up.
#pragma once

#include "haptics/force/carried_frame.h"
#include "haptics/force/contact_force.h"
#include "haptics/force/passivity.h"
#include "haptics/force/penalty_probe.h"
#include "haptics/force/ramp_observer.h"
#include "haptics/force/surface_texture.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scene/move_with_objects.h"
#include "haptics/scene/moving_surface.h"
#include "haptics/scene/scene_views.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/surface_properties.h"
#include "proxima/device.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"

#include <memory>
#include <optional>
#include <span>

namespace proxima {

/// The proxy's part of the options, in the model's units. `properties` must outlive the proxy.
[[nodiscard]] ProxyOptions proxy_options(const RenderOptions& options, const WorkspaceMap& map,
                                         const SurfaceProperties* properties) noexcept;

/// The surface of a renderer. All but `surface` may be null.
struct RenderedSurface {
    const ContactSurface* surface = nullptr;
    const SurfaceProperties* properties = nullptr;
    MovingSurface* scene = nullptr; ///< surface and properties, where each tick advances it
    std::unique_ptr<const ContactSurface> owned = nullptr; ///< surface, where the renderer owns it
    SceneView view = nullptr; ///< scene, where the renderer has it until its end
};

/// Refers to surface, scene and properties. One thread. noexcept and without allocation but for the
/// constructor.
class PROXIMA_HIDDEN SurfaceRenderer {
public:
    /// Options are limited to what the device can take. With a probe of penalty forces the proxy is
    /// not used, and radius, frictions, max_moves and shading have no effect.
    /// \pre check_render_settings() holds
    SurfaceRenderer(RenderedSurface rendered, const WorkspaceMap& map, const DeviceLimits& device,
                    const RenderOptions& options, std::optional<PenaltyProbe> probe = std::nullopt);

    [[nodiscard]] const RenderOptions& options() const noexcept { return options_; }
    [[nodiscard]] const WorkspaceMap& map() const noexcept { return map_; }
    [[nodiscard]] const Proxy& proxy() const noexcept { return proxy_; }
    [[nodiscard]] const ForceGuard& guard() const noexcept { return guard_; }
    [[nodiscard]] const PassivityGuard& passivity() const noexcept { return passivity_; }

    [[nodiscard]] const TextureForce& texture() const noexcept { return texture_; }

    /// Like HapticRenderer::tick().
    const RenderTick& tick(const DeviceState& state, double seconds, Patch patch) noexcept;

    /// Like HapticRenderer::reset().
    void reset() noexcept;

    [[nodiscard]] const RenderTick& last() const noexcept { return tick_; }

    /// The material that the last tick touched: the mean of its contacts' materials, weighted by
    /// pressure, with stiffness and damping limited to what the device can take. The options' numbers
    /// stand for surfaces without a material, and hold where nothing is touched.
    [[nodiscard]] SurfaceMaterial touched_material() const noexcept;

    /// Whether penalty forces pushed against the side of the tick before.
    [[nodiscard]] bool popped() const noexcept { return probe_ && probe_->popped(); }

    /// The last tick of the proxy, or of the probe of penalty forces.
    [[nodiscard]] const ProxyTick& proxy_tick() const noexcept
    {
        return probe_ ? probe_->last() : proxy_.last();
    }

    /// The path of the proxy, or of the probe of penalty forces, in the last tick: positions with
    /// straight moves between them.
    [[nodiscard]] std::span<const Vec3> path() const noexcept
    {
        return probe_ ? probe_->path() : proxy_.path();
    }

    /// The proxy's positions while objects of a scene moved in the last tick, before path(): with
    /// them straight to the first, and from there on among objects at rest. Empty where none moved.
    [[nodiscard]] std::span<const Vec3> carried_path() const noexcept
    {
        return is_carried_ ? settle_scratch_->path() : std::span<const Vec3>();
    }

private:
    void place(const Vec3& device) noexcept;
    void place_outside(const Vec3& p) noexcept;
    [[nodiscard]] bool is_inside(const Vec3& p) const noexcept;
    [[nodiscard]] const ProxyTick& follow(const Vec3& device) noexcept;
    void write_proxy(const ProxyTick& proxy) noexcept;
    [[nodiscard]] Vec3 accept(const DeviceState& state) noexcept;
    [[nodiscard]] double advance_scene(double seconds) noexcept;
    [[nodiscard]] CarriedGoal carry_goal(const Vec3& position) noexcept;
    [[nodiscard]] std::optional<Vec3> carried(const Vec3& position, const Vec3& goal) noexcept;
    [[nodiscard]] Vec3 settle(const Vec3& position, const CarriedGoal& goal) noexcept;
    using ApartTest = bool (MovingSurface::*)(ObjectId id, const Vec3& p, double distance) const;
    [[nodiscard]] bool is_at_exchanged_body(ApartTest is_apart) const noexcept;
    void start_anew() noexcept;
    void leave_ground() noexcept;
    [[nodiscard]] Vec3 surface_velocity(const ProxyTick& proxy) const noexcept;
    [[nodiscard]] ForceOptions force_of(TriangleId triangle) const noexcept;
    [[nodiscard]] ForceOptions mean_force(const ProxyTick& proxy) const noexcept;
    void feel_texture(const ProxyTick& proxy, const Vec3& velocity, double seconds) noexcept;
    [[nodiscard]] Vec3 texture_force(const ProxyTick& proxy, const Vec3& velocity) const noexcept;
    [[nodiscard]] Vec3 tap_force(const ProxyTick& proxy, const Vec3& force) noexcept;
    [[nodiscard]] Vec3 smooth_spring(const ProxyTick& proxy, const SpringContact& contact,
                                     const Vec3& velocity) const noexcept;
    [[nodiscard]] Vec3 spring(const ProxyTick& proxy, const Vec3& device,
                              const Vec3& velocity) const noexcept;
    [[nodiscard]] ContactForce contact_force(const ProxyTick& proxy, const Vec3& device,
                                             const Vec3& whole) const noexcept;

    std::unique_ptr<const ContactSurface> owned_;
    SceneView view_;
    const ContactSurface& surface_;
    MovingSurface* scene_ = nullptr;
    const SurfaceProperties* properties_ = nullptr;
    DeviceLimits device_;
    WorkspaceMap map_;
    RenderOptions options_;
    Proxy proxy_;
    std::optional<PenaltyProbe> probe_; ///< of penalty forces
    ForceGuard guard_;
    PassivityGuard passivity_;
    RampObserver ramp_observer_;
    TextureForce texture_;
    TextureTick textured_; ///< of this tick
    RenderTick tick_;
    CarryScratch carry_scratch_;
    std::optional<SlideScratch> settle_scratch_; ///< of a scene
    bool is_carried_ = false;
    Vec3 ground_ = Vec3::Zero(); ///< m: displacement by the touched surface
    CarriedFrame<3> frame_;
    Vec3 frame_position_ = Vec3::Zero(); ///< m
    bool placed_ = false;
};

/// The library's access to the parts of a HapticRenderer.
class PROXIMA_HIDDEN RendererAccess {
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

/// The renderer's proxy, guards and last slide, for tests and reports.
/// \pre the renderer was not moved from
[[nodiscard]] inline const SurfaceRenderer& parts_of(const HapticRenderer& renderer) noexcept
{
    return RendererAccess::parts(renderer);
}

/// Error invalid_argument, naming a number that is out of range.
[[nodiscard]] Status check_render_settings(const WorkspaceMap& map, const DeviceLimits& device,
                                           const RenderOptions& options);

/// A renderer of the library's own surfaces, with their materials and normals. Refers to both.
/// \pre check_render_settings() holds
[[nodiscard]] HapticRenderer make_surface_renderer(const ContactSurface& surface,
                                                   const WorkspaceMap& map,
                                                   const DeviceLimits& device,
                                                   const RenderOptions& options = {},
                                                   const SurfaceProperties* properties = nullptr);

/// A renderer of penalty forces. Refers to the surface. \pre check_render_settings() holds; inside has
/// signs
[[nodiscard]] HapticRenderer make_penalty_renderer(const ContactSurface& surface,
                                                   const MeshIndex& inside, const WorkspaceMap& map,
                                                   const DeviceLimits& device,
                                                   const RenderOptions& options);

} // namespace proxima
