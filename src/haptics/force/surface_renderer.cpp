#include "haptics/force/surface_renderer.h"

#include "haptics/surface/height_field.h"
#include "proxima/touch_scene.h"

#include <algorithm>
#include <utility>

namespace proxima {

namespace {

/// Squares of larger coordinates overflow.
constexpr double most_coordinate = 1e150;

RenderOptions limited_options(RenderOptions options, const DeviceLimits& device)
{
    options.force = limited(options.force, device);
    options.texture = limited(options.texture, options.force.stiffness, device);
    return options;
}

} // namespace

ProxyOptions proxy_options(const RenderOptions& options, const WorkspaceMap& map,
                           const SurfaceProperties* properties) noexcept
{
    // With shading the proxy slides twice.
    const std::size_t slides = options.shading == ForceShading::on ? 2 : 1;
    return {.radius = options.proxy_radius * map.units_per_metre,
            .static_friction = options.static_friction,
            .dynamic_friction = options.dynamic_friction,
            .max_moves = std::min(slides * options.max_moves, max_slide_moves),
            .shading = options.shading,
            .properties = properties};
}

SurfaceRenderer::SurfaceRenderer(RenderedSurface rendered, const WorkspaceMap& map,
                                 const DeviceLimits& device, const RenderOptions& options,
                                 std::optional<PenaltyProbe> probe)
    : owned_(std::move(rendered.owned)), view_(std::move(rendered.view)),
      surface_(*rendered.surface), scene_(rendered.scene), properties_(rendered.properties),
      device_(device), map_(map), options_(limited_options(options, device)),
      proxy_(surface_, proxy_options(options, map, rendered.properties)), probe_(std::move(probe)),
      guard_(options_.force, device.max_force), passivity_(options_.guard, device),
      ramp_observer_(device.max_damping),
      texture_(options_.texture, rendered.properties, device, map.units_per_metre)
{
    if (scene_ != nullptr) settle_scratch_.emplace();
}

Vec3 SurfaceRenderer::accept(const DeviceState& state) noexcept
{
    const Vec3& reported = state.pose.translation;
    tick_.fault = InputFault::none;
    if (!(map_.to_model(reported).array().abs() <= most_coordinate).all()) {
        tick_.fault = InputFault::not_finite;
        return tick_.position;
    }
    // The proxy follows a jump like any other motion, so it stays on its side of every surface.
    // Penalty forces know no side.
    if (placed_ && !((reported - tick_.position).norm() <= options_.max_jump)) {
        tick_.fault = InputFault::jumped;
        if (probe_) placed_ = false;
        guard_.restart();
        passivity_.restart();
        ramp_observer_.restart();
    }
    return reported;
}

/// Advances the objects, which carry the proxy. Returns the seconds by which they advanced.
double SurfaceRenderer::advance_scene(double seconds) noexcept
{
    const SceneTick change = scene_->advance(seconds);
    tick_.squeezed = false;
    is_carried_ = false;
    if (!placed_) return change.seconds;
    const ProxyTick& last = proxy_.last();
    const bool touched = change.exchanged && is_at_exchanged_body(&MovingSurface::was_apart);
    if (change.moved && last.is_placed) {
        const CarriedGoal goal = carry_goal(last.proxy);
        const auto position = carried(last.proxy, goal.position);
        if (position) {
            // A frictionless position of its own is carried separately.
            const Vec3 frictionless = last.slide.center;
            const bool apart = last.hold != Hold::free && frictionless != last.proxy;
            const Vec3 settled = settle(*position, goal);
            proxy_.carry(
                settled,
                apart ? carried(frictionless, carry_goal(frictionless).position).value_or(settled)
                      : settled);
            is_carried_ = true;
        } else {
            tick_.squeezed = true;
            start_anew();
        }
    }
    if (touched || (change.exchanged && is_at_exchanged_body(&MovingSurface::is_apart)))
        start_anew();
    return change.seconds;
}

/// Whether a body that was exchanged in this tick is, by that test, not apart from the proxy and the
/// frictionless position.
bool SurfaceRenderer::is_at_exchanged_body(ApartTest is_apart) const noexcept
{
    const ProxyTick& last = proxy_.last();
    const double distance = proxy_.radius() + safety_gap(scene_->scale());
    for (std::uint32_t i = 0; i < scene_->object_count(); ++i) {
        const ObjectId id{i};
        if (!scene_->object(id).exchanged) continue;
        if (!(scene_->*is_apart)(id, last.proxy, distance)) return true;
        if (!(scene_->*is_apart)(id, last.slide.center, distance)) return true;
    }
    return false;
}

/// Where the objects that the proxy touches would carry a position of it.
CarriedGoal SurfaceRenderer::carry_goal(const Vec3& position) noexcept
{
    const ProxyTick& last = proxy_.last();
    if (last.hold == Hold::free) return {position, 0, 0};
    const auto contacts = std::span(last.slide.contacts).first(last.slide.contact_count);
    return carried_position(*scene_, proxy_.radius(), contacts, position, carry_scratch_);
}

/// A position of the proxy after the objects moved, near that goal.
std::optional<Vec3> SurfaceRenderer::carried(const Vec3& position, const Vec3& goal) noexcept
{
    return move_with_objects(*scene_, proxy_.radius(), position, goal, carry_scratch_);
}

/// Slides the carried proxy to its goal where it is on a shape that changes: planes of triangles
/// that turn keep it a little above them. Not where its contacts took it different ways, or others
/// held it back: such a goal may be behind a surface, and the way there about its border.
Vec3 SurfaceRenderer::settle(const Vec3& position, const CarriedGoal& goal) noexcept
{
    const ProxyTick& last = proxy_.last();
    settle_scratch_->begin_path(position);
    if (last.hold == Hold::free || goal.spread > 0.5 * goal.way) return position;
    const auto contacts = std::span(last.slide.contacts).first(last.slide.contact_count);
    const bool changes = std::ranges::any_of(contacts, [&](const Contact& contact) {
        return scene_->object(object_of(contact.triangle)).changed;
    });
    const Vec3 lift = position - goal.position;
    const bool is_above = std::ranges::any_of(contacts, [&](const Contact& contact) {
        return contact.normal.dot(lift) > 0.5 * lift.norm();
    });
    if (!changes || !is_above) return position;
    const ProxyOptions& options = proxy_.options();
    return slide_sphere(*scene_, options.radius, position, goal.position, *settle_scratch_,
                        SlideStart::touching, options.max_moves)
        .center;
}

/// Places the proxy anew, outside of closed bodies, one of which may now cover it.
void SurfaceRenderer::start_anew() noexcept
{
    place_outside(surface_.nearest_exit(proxy_.last().proxy));
    guard_.cross_over();
    passivity_.restart();
    frame_.restart();
}

/// Velocity of the surface under the proxy, m/s: mean of the contacts, weighted by pressure.
Vec3 SurfaceRenderer::surface_velocity(const ProxyTick& proxy) const noexcept
{
    const SlideResult& slide = proxy.slide;
    Vec3 sum = Vec3::Zero();
    double pressures = 0;
    for (const Contact& contact : std::span(slide.contacts).first(slide.contact_count)) {
        sum += contact.pressure * scene_->velocity_at(contact.triangle, proxy.proxy);
        pressures += contact.pressure;
    }
    return pressures > 0 ? Vec3(sum / (pressures * map_.units_per_metre)) : Vec3(Vec3::Zero());
}

/// The spring and damper of one contact: its material's, as far as the device can take it.
ForceOptions SurfaceRenderer::force_of(TriangleId triangle) const noexcept
{
    ForceOptions own = options_.force;
    if (properties_ == nullptr) return own;
    if (const auto material = properties_->material(triangle)) {
        own.stiffness = material->stiffness;
        own.damping = material->damping;
        own = limited(own, device_);
    }
    return own;
}

/// Spring and damper of the contacts, a mean by pressure.
ForceOptions SurfaceRenderer::mean_force(const ProxyTick& proxy) const noexcept
{
    if (properties_ == nullptr) return options_.force;
    ForceOptions mean = options_.force;
    double pressures = 0;
    double stiffness = 0;
    double damping = 0;
    for (const Contact& each : std::span(proxy.slide.contacts).first(proxy.slide.contact_count)) {
        const ForceOptions own = force_of(each.triangle);
        stiffness += each.pressure * own.stiffness;
        damping += each.pressure * own.damping;
        pressures += each.pressure;
    }
    if (!(pressures > 0)) return mean;
    mean.stiffness = stiffness / pressures;
    mean.damping = damping / pressures;
    return mean;
}

SurfaceMaterial SurfaceRenderer::touched_material() const noexcept
{
    const ForceOptions force = mean_force(proxy_tick());
    const Proxy::Friction friction = proxy_.friction_without_grip();
    return {force.stiffness, force.damping, friction.fixed, friction.sliding};
}

/// Advances the texture under the proxy, if there is one.
void SurfaceRenderer::feel_texture(const ProxyTick& proxy, const Vec3& velocity,
                                   double seconds) noexcept
{
    textured_ = {};
    if (tick_.fault == InputFault::jumped) texture_.release(seconds);
    if (texture_.touches(proxy)) {
        const bool steady = guard_.ramp() >= 1 && tick_.fault == InputFault::none &&
                            tick_.condition == InputCondition::well;
        textured_ = texture_.pass(proxy, {.stiffness = mean_force(proxy).stiffness,
                                          .position = tick_.position - ground_,
                                          .velocity = velocity,
                                          .ground = ground_,
                                          .seconds = seconds,
                                          .damps = options_.guard == Guard::on,
                                          .taps = steady && passivity_.softness() >= 1});
    } else {
        texture_.release(seconds);
    }
    proxy_.set_grip(textured_.grip);
    tick_.texture = Vec3::Zero();
    if (!textured_.acts) return;
    tick_.texture = texture_force(proxy, velocity) -
                    mean_force(proxy).stiffness * textured_.groove * proxy.normal;
}

/// What the texture adds along the surface.
Vec3 SurfaceRenderer::texture_force(const ProxyTick& proxy, const Vec3& velocity) const noexcept
{
    const Vec3 along = velocity - velocity.dot(proxy.normal) * proxy.normal;
    return textured_.along - (textured_.viscosity + textured_.added_damping) * along;
}

/// The tap of this tick, which never makes the force pull against the contact's normal.
Vec3 SurfaceRenderer::tap_force(const ProxyTick& proxy, const Vec3& force) noexcept
{
    tick_.tap = texture_.tap();
    if (tick_.tap == 0) return Vec3::Zero();
    tick_.tap = std::max(tick_.tap, -std::max(force.dot(proxy.normal), 0.0));
    return tick_.tap * proxy.normal;
}

/// Spring and damper. Objects of different materials push with their own stiffness along their
/// normals. Damping and the spring of friction use means, weighted by pressure.
Vec3 SurfaceRenderer::smooth_spring(const ProxyTick& proxy, const SpringContact& contact,
                                    const Vec3& velocity) const noexcept
{
    if (properties_ == nullptr || !contact.touching)
        return spring_force(options_.force, contact, velocity);
    const ForceOptions mean = mean_force(proxy);
    Vec3 pushes = Vec3::Zero();    // N: with each contact's own stiffness
    Vec3 stretches = Vec3::Zero(); // m: their part of the stretch
    for (const Contact& each : std::span(proxy.slide.contacts).first(proxy.slide.contact_count)) {
        const Vec3 pressed = each.pressure / map_.units_per_metre * each.normal;
        pushes += force_of(each.triangle).stiffness * pressed;
        stretches += pressed;
    }
    return spring_force(mean, contact, velocity) + (pushes - mean.stiffness * stretches);
}

/// Spring and damper with the texture, whose grooves lessen the depth.
Vec3 SurfaceRenderer::spring(const ProxyTick& proxy, const Vec3& device,
                             const Vec3& velocity) const noexcept
{
    const Vec3 stretch = (proxy.anchor - device) / map_.units_per_metre;
    SpringContact contact = {proxy.hold != Hold::free, stretch, proxy.normal};
    if (!textured_.acts) return smooth_spring(proxy, contact, velocity);
    if (!textured_.presses) return Vec3::Zero();
    contact.stretch -= textured_.groove * proxy.normal;
    return smooth_spring(proxy, contact, velocity) + texture_force(proxy, velocity);
}

/// Places the proxy, unless a closed body contains its place: then it waits for the device.
void SurfaceRenderer::place_outside(const Vec3& p) noexcept
{
    proxy_.place(p);
    const Vec3 position = proxy_.last().proxy;
    if (is_inside(position)) proxy_.wait(position);
}

bool SurfaceRenderer::is_inside(const Vec3& p) const noexcept
{
    return surface_.nearest_exit(p) != p;
}

/// The contact's force and its parts, as the passivity guard weighs them.
ContactForce SurfaceRenderer::contact_force(const ProxyTick& proxy, const Vec3& device,
                                            const Vec3& whole) const noexcept
{
    const Vec3 still = Vec3::Zero();
    const Vec3 elastic = probe_ ? penalty_force(options_.force, proxy.depth / map_.units_per_metre,
                                                proxy.normal, still)
                                : spring(proxy, device, still);
    double stiffness = options_.force.stiffness;
    double damping = options_.force.damping;
    if (properties_ != nullptr) {
        const auto contacts = std::span(proxy.slide.contacts).first(proxy.slide.contact_count);
        if (!contacts.empty()) stiffness = damping = 0;
        for (const Contact& each : contacts) {
            const ForceOptions own = force_of(each.triangle);
            stiffness = std::max(stiffness, own.stiffness);
            damping = std::max(damping, own.damping);
        }
    }
    return {elastic, whole, stiffness, damping, textured_.pull};
}

/// No surface carries the device any more.
void SurfaceRenderer::leave_ground() noexcept
{
    ground_ = frame_position_ = Vec3::Zero();
    frame_.restart();
}

void SurfaceRenderer::reset() noexcept
{
    placed_ = false;
    tick_ = {};
    leave_ground();
    guard_.restart();
    passivity_.reset();
    ramp_observer_.restart();
    texture_.reset();
    textured_ = {};
    proxy_.set_grip(1);
}

void SurfaceRenderer::place(const Vec3& device) noexcept
{
    if (probe_) {
        probe_->place(device);
    } else {
        place_outside(device);
    }
}

const ProxyTick& SurfaceRenderer::follow(const Vec3& device) noexcept
{
    if (probe_) return probe_->follow(device);
    const bool waits = !proxy_.last().is_placed && is_inside(device);
    return waits ? proxy_.wait(device) : proxy_.follow(device);
}

/// Copies the proxy's part of the tick.
void SurfaceRenderer::write_proxy(const ProxyTick& proxy) noexcept
{
    tick_.proxy = proxy.proxy;
    tick_.anchor = proxy.anchor;
    tick_.hold = proxy.hold;
    tick_.normal = proxy.normal;
    tick_.depth = proxy.depth;
    tick_.is_placed = proxy.is_placed;
    tick_.moves = proxy.moves;
    tick_.slide_end = proxy.slide.end;
    tick_.contact_count = proxy.slide.contact_count;
    for (std::size_t i = 0; i < proxy.slide.contact_count; ++i) {
        const Contact& contact = proxy.slide.contacts[i];
        tick_.contacts[i] = {contact.point, contact.normal, contact.triangle, contact.pressure};
    }
}

const RenderTick& SurfaceRenderer::tick(const DeviceState& state, double seconds,
                                        Patch patch) noexcept
{
    tick_.position = accept(state);
    tick_.condition = state.condition;
    const Vec3 device = map_.to_model(tick_.position);
    const double advanced = scene_ != nullptr ? advance_scene(seconds) : seconds;
    if (!placed_) {
        if (tick_.fault == InputFault::not_finite) return tick_;
        place(device);
        placed_ = true;
    }
    const ProxyTick& proxy = follow(device);
    write_proxy(proxy);
    const bool touching = proxy.hold != Hold::free;
    Vec3 velocity = state.velocity.allFinite() ? state.velocity : Vec3(Vec3::Zero());
    Vec3 guarded_velocity = velocity;
    if (scene_ != nullptr) {
        tick_.surface_velocity = touching ? surface_velocity(proxy) : Vec3(Vec3::Zero());
        velocity -= tick_.surface_velocity;
        const Vec3 carried = advanced * tick_.surface_velocity;
        ground_ += carried;
        if (advanced > 0) frame_position_ += frame_.step(touching ? &carried : nullptr, advanced);
        guarded_velocity -= frame_.velocity();
    }
    if (!probe_) feel_texture(proxy, velocity, seconds);
    tick_.spring = probe_ ? penalty_force(options_.force, proxy.depth / map_.units_per_metre,
                                          proxy.normal, velocity)
                          : spring(proxy, device, velocity);
    if (tick_.fault == InputFault::jumped && !probe_) {
        // The proxy may still be on its way: the force rises from the next tick on.
        tick_.force = Vec3::Zero();
        tick_.tap = 0;
        return tick_;
    }
    Vec3 force = tick_.spring;
    if (options_.guard != Guard::off) {
        // Ramps change the energy that the spring has stored.
        const Vec3 relative = tick_.position - ground_;
        const bool ramps = guard_.ramp() < 1;
        if (ramps) passivity_.restart();
        if (!ramps || !touching) {
            ramp_observer_.restart();
        } else if (options_.guard == Guard::on) {
            force = ramp_observer_.pass(relative, velocity, force, seconds);
        }
        ContactForce contact;
        if (touching) contact = contact_force(proxy, device, force);
        contact.surface = ground_ - frame_position_;
        contact.surface_velocity = tick_.surface_velocity;
        force =
            passivity_.pass(tick_.position - frame_position_, guarded_velocity, contact, seconds);
        if (passivity_.is_away() && ground_ != Vec3::Zero()) {
            passivity_.restart();
            leave_ground();
        }
    }
    const Vec3 tap = tap_force(proxy, force);
    if (tick_.tap != 0) force += tap;
    const bool available = patch == Patch::available && tick_.fault != InputFault::not_finite &&
                           state.condition == InputCondition::well;
    tick_.force = guard_.pass(force, seconds, available ? Patch::available : Patch::lost);
    passivity_.applied(tick_.tap != 0 ? Vec3(tick_.force - tap) : tick_.force);
    ramp_observer_.applied(tick_.force);
    return tick_;
}

} // namespace proxima
