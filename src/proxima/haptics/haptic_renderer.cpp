#include "proxima/haptics/haptic_renderer.h"

#include <algorithm>

namespace proxima {

namespace {

RenderOptions limited_options(RenderOptions options, const DeviceLimits& device)
{
    options.force = limited(options.force, device);
    return options;
}

} // namespace

HapticRenderer::HapticRenderer(const ContactSurface& surface, const WorkspaceMap& map,
                               const DeviceLimits& device, const RenderOptions& options)
    : map_(map), options_(limited_options(options, device)),
      proxy_(surface, {.radius = options.proxy_radius * map.units_per_metre,
                       .static_friction = options.static_friction,
                       .dynamic_friction = options.dynamic_friction,
                       .max_moves = options.max_moves}),
      guard_(options_.force, device.max_force), passivity_(device.max_damping)
{}

Vec3 HapticRenderer::accept(const DeviceState& state) noexcept
{
    const Vec3& said = state.pose.translation;
    tick_.fault = InputFault::none;
    if (!said.allFinite()) {
        tick_.fault = InputFault::not_finite;
        return tick_.position;
    }
    if (placed_ && !((said - tick_.position).norm() <= options_.max_jump)) {
        tick_.fault = InputFault::jumped;
        placed_ = false;
        guard_.restart();
        passivity_.restart();
    }
    return said;
}

const RenderTick& HapticRenderer::tick(const DeviceState& state, double seconds,
                                       Patch patch) noexcept
{
    tick_.position = accept(state);
    const Vec3 device = map_.to_model(tick_.position);
    if (!placed_) {
        if (!device.allFinite()) return tick_;
        proxy_.place(device);
        placed_ = true;
    }
    tick_.proxy = proxy_.follow(device);
    const Vec3 velocity = state.velocity.allFinite() ? state.velocity : Vec3(Vec3::Zero());
    const bool touching = tick_.proxy.hold != Hold::free;
    const Vec3 stretch = (tick_.proxy.held - device) / map_.units_per_metre;
    tick_.spring = spring_force(options_.force, {touching, stretch, tick_.proxy.normal}, velocity);
    Vec3 force = tick_.spring;
    if (!touching) {
        passivity_.restart();
    } else if (options_.passivity == Passivity::guarded) {
        force = passivity_.pass(tick_.position, velocity, force, seconds);
    }
    const bool trusted = patch == Patch::at_hand && tick_.fault != InputFault::not_finite;
    tick_.force = guard_.pass(force, seconds, trusted ? Patch::at_hand : Patch::lost);
    passivity_.applied(tick_.force);
    return tick_;
}

} // namespace proxima
