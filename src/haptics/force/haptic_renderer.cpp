#include "proxima/haptic_renderer.h"

#include "base/text.h"
#include "haptics/device/check_numbers.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/scene/touch_access.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/exits.h"
#include "haptics/surface/height_field.h"
#include "proxima/device.h"
#include "proxima/mesh_index.h"
#include "proxima/touch_scene.h"

#include <utility>

namespace proxima {

namespace {

Result<RenderedSurface> surface_of_index(const MeshIndex& index)
{
    const auto with = with_exits(index);
    if (!with) return tl::unexpected(with.error());
    auto surface = IndexContactSurface::make(*with);
    if (!surface) return tl::unexpected(surface.error());
    RenderedSurface rendered;
    rendered.owned = std::move(*surface);
    rendered.surface = rendered.owned.get();
    return rendered;
}

RenderedSurface surface_of_view(SceneView view)
{
    MovingSurface* const scene = view.get();
    return {.surface = scene, .properties = scene, .scene = scene, .view = std::move(view)};
}

HapticRenderer renderer_of(RenderedSurface surface, const WorkspaceMap& map,
                           const DeviceLimits& device, const RenderOptions& options)
{
    return RendererAccess::wrap(
        std::make_unique<SurfaceRenderer>(std::move(surface), map, device, options));
}

} // namespace

HapticRenderer::HapticRenderer(std::unique_ptr<SurfaceRenderer> renderer) noexcept
    : renderer_(std::move(renderer))
{}

HapticRenderer::HapticRenderer(HapticRenderer&& other) noexcept = default;
HapticRenderer& HapticRenderer::operator=(HapticRenderer&& other) noexcept = default;
HapticRenderer::~HapticRenderer() = default;

const RenderOptions& HapticRenderer::options() const noexcept
{
    return renderer_->options();
}

const WorkspaceMap& HapticRenderer::map() const noexcept
{
    return renderer_->map();
}

const RenderTick& HapticRenderer::tick(const DeviceState& state, double seconds,
                                       Patch patch) noexcept
{
    return renderer_->tick(state, seconds, patch);
}

const RenderTick& HapticRenderer::last() const noexcept
{
    return renderer_->last();
}

void HapticRenderer::reset() noexcept
{
    renderer_->reset();
}

std::span<const Vec3> HapticRenderer::path() const noexcept
{
    return renderer_->path();
}

Status check_render_settings(const WorkspaceMap& map, const DeviceLimits& device,
                             const RenderOptions& options)
{
    for (const NamedNumber number : {NamedNumber{"units_per_metre", map.units_per_metre},
                                     NamedNumber{"max_force", device.max_force}}) {
        if (Status status = check_positive(number); !status) return status;
    }
    if (!map.center.allFinite()) {
        return fail(ErrorCode::invalid_argument, "the center of the workspace must be finite",
                    "center");
    }
    const ForceOptions& force = options.force;
    if (Status status = check_not_negative({{"max_stiffness", device.max_stiffness},
                                            {"max_damping", device.max_damping},
                                            {"stiffness", force.stiffness},
                                            {"damping", force.damping},
                                            {"max_slew", force.max_slew},
                                            {"start_seconds", force.start_seconds},
                                            {"loss_seconds", force.loss_seconds},
                                            {"proxy_radius", options.proxy_radius},
                                            {"static_friction", options.static_friction},
                                            {"dynamic_friction", options.dynamic_friction},
                                            {"max_jump", options.max_jump}});
        !status)
        return status;
    if (options.dynamic_friction > options.static_friction) {
        return fail(ErrorCode::invalid_argument,
                    concat("dynamic friction must be at most static friction, ",
                           options.static_friction, ", not ", options.dynamic_friction),
                    "dynamic_friction");
    }
    if (options.max_moves < least_slide_moves || options.max_moves > max_slide_moves) {
        return fail(ErrorCode::invalid_argument,
                    concat("max_moves must be ", least_slide_moves, " to ", max_slide_moves,
                           ", not ", options.max_moves),
                    "max_moves");
    }
    return check_texture(options.texture);
}

Result<HapticRenderer> make_haptic_renderer(const MeshIndex& index, const WorkspaceMap& map,
                                            const DeviceLimits& device,
                                            const RenderOptions& options)
{
    if (Status status = check_render_settings(map, device, options); !status)
        return tl::unexpected(status.error());
    auto surface = surface_of_index(index);
    if (!surface) return tl::unexpected(surface.error());
    return renderer_of(std::move(*surface), map, device, options);
}

Result<HapticRenderer> make_haptic_renderer(TouchScene& scene, const WorkspaceMap& map,
                                            const DeviceLimits& device,
                                            const RenderOptions& options)
{
    if (Status status = check_render_settings(map, device, options); !status)
        return tl::unexpected(status.error());
    auto view = scene_views(scene).take();
    if (!view) return tl::unexpected(view.error());
    return renderer_of(surface_of_view(std::move(*view)), map, device, options);
}

HapticRenderer make_surface_renderer(const ContactSurface& surface, const WorkspaceMap& map,
                                     const DeviceLimits& device, const RenderOptions& options,
                                     const SurfaceProperties* properties)
{
    return renderer_of({.surface = &surface, .properties = properties}, map, device, options);
}

HapticRenderer make_penalty_renderer(const ContactSurface& surface, const MeshIndex& inside,
                                     const WorkspaceMap& map, const DeviceLimits& device,
                                     const RenderOptions& options)
{
    return RendererAccess::wrap(std::make_unique<SurfaceRenderer>(
        RenderedSurface{.surface = &surface}, map, device, options, PenaltyProbe(inside)));
}

} // namespace proxima
