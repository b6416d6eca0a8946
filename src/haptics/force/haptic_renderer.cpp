#include "proxima/haptic_renderer.h"

#include "haptics/force/surface_renderer.h"
#include "haptics/scene/touch_access.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/device.h"
#include "proxima/mesh_index.h"
#include "proxima/touch_scene.h"

#include <utility>

namespace proxima {

namespace {

RenderedSurface surface_of_index(const MeshIndex& index)
{
    RenderedSurface rendered;
    rendered.owned = std::make_unique<IndexContactSurface>(index);
    rendered.surface = rendered.owned.get();
    return rendered;
}

RenderedSurface surface_of_scene(MovingSurface& scene)
{
    return {.surface = &scene, .feel = &scene, .scene = &scene};
}

} // namespace

HapticRenderer::HapticRenderer(std::unique_ptr<SurfaceRenderer> renderer) noexcept
    : renderer_(std::move(renderer))
{}

HapticRenderer::HapticRenderer(const MeshIndex& index, const WorkspaceMap& map,
                               const DeviceLimits& device, const RenderOptions& options)
    : renderer_(std::make_unique<SurfaceRenderer>(surface_of_index(index), map, device, options))
{}

HapticRenderer::HapticRenderer(TouchScene& scene, const WorkspaceMap& map,
                               const DeviceLimits& device, const RenderOptions& options)
    : renderer_(std::make_unique<SurfaceRenderer>(surface_of_scene(moving_surface(scene)), map,
                                                  device, options))
{}

HapticRenderer::HapticRenderer(const ContactSurface& surface, const WorkspaceMap& map,
                               const DeviceLimits& device, const RenderOptions& options,
                               const SurfaceFeel* feel)
    : renderer_(std::make_unique<SurfaceRenderer>(
          RenderedSurface{.surface = &surface, .feel = feel}, map, device, options))
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

std::span<const Vec3> HapticRenderer::path() const noexcept
{
    return renderer_->path();
}

HapticRenderer make_penalty_renderer(const ContactSurface& surface, const PenaltySurface& inside,
                                     const WorkspaceMap& map, const DeviceLimits& device,
                                     const RenderOptions& options)
{
    return RendererAccess::wrap(std::make_unique<SurfaceRenderer>(
        RenderedSurface{.surface = &surface}, map, device, options, PenaltyProbe(inside)));
}

} // namespace proxima
