#include "proxima/haptics/proxy.h"

#include "proxima/base/check.h"
#include "proxima/haptics/free_place.h"

#include <algorithm>

namespace proxima {

Proxy::Proxy(const ContactSurface& surface, const ProxyOptions& options)
    : surface_(surface), options_(options),
      radius_(std::max(options.radius, safety_gap(surface.scale())))
{
    PROXIMA_CHECK_GE(options.radius, 0);
    PROXIMA_CHECK_GE(options.dynamic_friction, 0);
    PROXIMA_CHECK_LE(options.dynamic_friction, options.static_friction);
}

void Proxy::place(const Vec3& p) noexcept
{
    tick_ = {};
    const auto free = find_free_place(surface_, radius_, p, room_);
    tick_.proxy = tick_.held = free.value_or(p);
    tick_.has_room = free.has_value();
}

const ProxyTick& Proxy::wait(const Vec3& p) noexcept
{
    tick_ = {};
    tick_.proxy = tick_.held = p;
    tick_.has_room = false;
    return tick_;
}

/// Whether there is room now, after there was none: where the device itself is.
bool Proxy::find_room(const Vec3& p) noexcept
{
    wait(p);
    tick_.has_room = surface_.clearance(p) > radius_;
    return tick_.has_room;
}

Proxy::Friction Proxy::friction_of(const SlideResult& slide) const noexcept
{
    const Friction own = {options_.static_friction, options_.dynamic_friction};
    if (options_.feel == nullptr) return own;
    Friction sum;
    double pressures = 0;
    for (const Contact& contact : std::span(slide.contacts).first(slide.contact_count)) {
        Friction friction = own;
        if (const auto material = options_.feel->material(contact.triangle))
            friction = {material->static_friction, material->dynamic_friction};
        sum.fixed += contact.pressure * friction.fixed;
        sum.sliding += contact.pressure * friction.sliding;
        pressures += contact.pressure;
    }
    if (!(pressures > 0)) return own;
    return {sum.fixed / pressures, sum.sliding / pressures};
}

/// How far aside the goal is moved, for the spring to lean along the smooth normal.
Vec3 Proxy::shading_of(const SlideResult& slide, const Vec3& normal, double depth) const noexcept
{
    if (options_.shading == ForceShading::off || options_.feel == nullptr) return Vec3::Zero();
    Vec3 smooth = Vec3::Zero();
    for (const Contact& contact : std::span(slide.contacts).first(slide.contact_count)) {
        const Vec3 shaded = options_.feel->shaded_normal(contact.triangle, contact.point);
        if (shaded.isZero(0)) return Vec3::Zero();
        // Surfaces have two sides.
        smooth += contact.pressure * (shaded.dot(contact.normal) < 0 ? Vec3(-shaded) : shaded);
    }
    const double rise = smooth.dot(normal);
    constexpr double least = 0.5; // beyond 60 degrees it says nothing of this surface
    if (!(rise > least * smooth.norm())) return Vec3::Zero();
    return depth * (smooth / rise - normal);
}

const ProxyTick& Proxy::follow(const Vec3& p) noexcept
{
    if (!tick_.has_room && !find_room(p)) return tick_;
    const Hold before = tick_.hold;
    const Vec3 start = tick_.proxy;
    const SlideStart known = before == Hold::free ? SlideStart::anywhere : SlideStart::touching;
    const SlideResult slide = slide_sphere(surface_, options_.radius, start, p, room_, known);
    ProxyTick next;
    next.slide = slide;
    next.proxy = slide.center;
    next.held = slide.held;
    next.moves = slide.moves;
    const Vec3 back = slide.held - p;
    next.depth = back.norm();
    if (slide.contact_count == 0 || !(next.depth > 0)) {
        tick_ = next;
        return tick_;
    }
    next.normal = back / next.depth;
    next.hold = Hold::sliding;
    std::size_t first_contact = slide.first_contact;
    const Vec3 lean = shading_of(slide, next.normal, next.depth);
    if (!lean.isZero(0)) {
        const SlideResult shaded =
            slide_sphere(surface_, options_.radius, start, p + lean, room_, known);
        next.moves += shaded.moves;
        next.proxy = shaded.center;
        next.held = shaded.contact_count > 0 ? shaded.held : Vec3(slide.held + lean);
        first_contact = shaded.contact_count > 0 ? shaded.first_contact : shaded.moves;
    }
    const Friction friction = friction_of(slide);
    if (friction.fixed > 0) {
        // Friction begins where the surface was met first.
        const std::size_t met = before == Hold::free ? first_contact : 0;
        const Vec3 anchor = room_.path()[met];
        const Vec3 goal = next.proxy;
        Vec3 aside = anchor - goal;
        aside -= next.normal * next.normal.dot(aside);
        const double distance = aside.norm();
        const double part = before == Hold::sliding ? options_.restick : 1;
        if (distance <= part * friction.fixed * next.depth) next.hold = Hold::sticking;
        const double trail = friction.sliding * next.depth;
        if (next.hold == Hold::sticking || distance <= trail) {
            room_.cut_path(met);
            next.proxy = anchor;
            next.held += anchor - goal;
        } else {
            const Vec3 lag = lean + aside * (trail / distance);
            const SlideResult dragged = slide_sphere(surface_, options_.radius, start, p + lag,
                                                     room_, SlideStart::touching);
            next.moves += dragged.moves;
            next.proxy = dragged.center;
            next.held = dragged.contact_count > 0 ? dragged.held : dragged.center;
        }
    }
    tick_ = next;
    return tick_;
}

} // namespace proxima
