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
    if (options.shading == ForceShading::on) long_path_.reserve(3 * (max_slide_moves + 1));
}

void Proxy::place(const Vec3& p) noexcept
{
    tick_ = {};
    const auto free = find_free_place(surface_, radius_, p, room_);
    smooth_place_ = tick_.proxy = tick_.held = free.value_or(p);
    tick_.has_room = free.has_value();
}

const ProxyTick& Proxy::wait(const Vec3& p) noexcept
{
    tick_ = {};
    smooth_place_ = tick_.proxy = tick_.held = p;
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

/// Slides from the smooth place aside. Returns how much of it a wall leaves.
Vec3 Proxy::lean_towards(const Vec3& p, const Vec3& lean, ProxyTick& next) noexcept
{
    leans_ = true;
    const auto way = room_.path();
    long_path_.assign(way.begin(), way.end());
    const Vec3 from = next.slide.center;
    const SlideResult aside =
        slide_sphere(surface_, options_.radius, from, p + lean, room_, SlideStart::touching);
    long_path_.insert(long_path_.end(), room_.path().begin(), room_.path().end());
    next.moves += aside.moves;
    next.proxy = aside.center;
    const double part = (aside.center - from).dot(lean) / lean.squaredNorm();
    return std::clamp(part, 0.0, 1.0) * lean;
}

const ProxyTick& Proxy::follow(const Vec3& p) noexcept
{
    leans_ = false;
    if (!tick_.has_room && !find_room(p)) return tick_;
    const Hold before = tick_.hold;
    const bool shades = options_.shading == ForceShading::on && options_.feel != nullptr;
    const Vec3 start = shades ? smooth_place_ : tick_.proxy;
    const SlideStart known = before == Hold::free ? SlideStart::anywhere : SlideStart::touching;
    const SlideResult slide = slide_sphere(surface_, options_.radius, start, p, room_, known);
    ProxyTick next;
    next.slide = slide;
    smooth_place_ = next.proxy = slide.center;
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
    // Friction begins where the surface was met first.
    const std::size_t met = before == Hold::free ? slide.first_contact : 0;
    const Vec3 anchor = shades && before != Hold::free ? tick_.proxy : room_.path()[met];
    Vec3 lean = shades ? shading_of(slide, next.normal, next.depth) : Vec3(Vec3::Zero());
    if (!lean.isZero(0)) {
        lean = lean_towards(p, lean, next);
        next.held += lean;
    }
    const Friction friction = friction_of(slide);
    if (friction.fixed > 0) {
        const Vec3 goal = slide.center + lean;
        Vec3 aside = anchor - goal;
        aside -= next.normal * next.normal.dot(aside);
        const double distance = aside.norm();
        const double part = before == Hold::sliding ? options_.restick : 1;
        if (distance <= part * friction.fixed * next.depth) next.hold = Hold::sticking;
        const double trail = friction.sliding * next.depth;
        if (next.hold == Hold::sticking || distance <= trail) {
            if (!shades) room_.cut_path(met);
            next.proxy = anchor;
            next.held += anchor - goal;
        } else {
            const Vec3 lag = aside * (trail / distance);
            const SlideResult dragged =
                slide_sphere(surface_, options_.radius, shades ? slide.center : start,
                             p + lean + lag, room_, SlideStart::touching);
            next.moves += dragged.moves;
            next.proxy = dragged.center;
            if (leans_) {
                next.held += lag;
                long_path_.push_back(slide.center);
                long_path_.insert(long_path_.end(), room_.path().begin(), room_.path().end());
            } else {
                next.held = dragged.contact_count > 0 ? dragged.held : dragged.center;
            }
        }
    }
    tick_ = next;
    return tick_;
}

} // namespace proxima
