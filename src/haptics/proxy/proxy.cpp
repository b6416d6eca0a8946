#include "haptics/proxy/proxy.h"

#include "base/check.h"
#include "haptics/proxy/free_position.h"

#include <algorithm>

namespace proxima {

Proxy::Proxy(const ContactSurface& surface, const ProxyOptions& options)
    : surface_(surface), options_(options),
      radius_(std::max(options.radius, safety_gap(surface.scale())))
{
    PROXIMA_CHECK_GE(options.radius, 0);
    PROXIMA_CHECK_GE(options.dynamic_friction, 0);
    PROXIMA_CHECK_LE(options.dynamic_friction, options.static_friction);
    PROXIMA_CHECK_GE(options.max_moves, least_slide_moves);
    PROXIMA_CHECK_LE(options.max_moves, max_slide_moves);
}

void Proxy::place(const Vec3& p) noexcept
{
    tick_ = {};
    const auto free = find_free_position(surface_, radius_, p, scratch_);
    tick_.proxy = tick_.anchor = free.value_or(p);
    tick_.is_placed = free.has_value();
}

const ProxyTick& Proxy::wait(const Vec3& p) noexcept
{
    tick_ = {};
    tick_.proxy = tick_.anchor = tick_.slide.center = p;
    tick_.is_placed = false;
    return tick_;
}

/// Tries to place the proxy at the device itself.
bool Proxy::find_free(const Vec3& p) noexcept
{
    wait(p);
    tick_.is_placed = surface_.clearance_beyond(p, radius_) > radius_;
    return tick_.is_placed;
}

Proxy::Friction Proxy::friction_of(const SlideResult& slide, double grip) const noexcept
{
    const Friction own = {grip * options_.static_friction, grip * options_.dynamic_friction};
    if (options_.properties == nullptr) return own;
    Friction sum;
    double pressures = 0;
    for (const Contact& contact : std::span(slide.contacts).first(slide.contact_count)) {
        Friction friction = own;
        if (const auto material = options_.properties->material(contact.triangle))
            friction = {grip * material->static_friction, grip * material->dynamic_friction};
        sum.fixed += contact.pressure * friction.fixed;
        sum.sliding += contact.pressure * friction.sliding;
        pressures += contact.pressure;
    }
    if (!(pressures > 0)) return own;
    return {sum.fixed / pressures, sum.sliding / pressures};
}

/// The displacement of the goal that makes the spring lean along the smooth normal.
Vec3 Proxy::shading_of(const SlideResult& slide, const Vec3& normal, double depth) const noexcept
{
    if (options_.shading == ForceShading::off || options_.properties == nullptr)
        return Vec3::Zero();
    Vec3 smooth = Vec3::Zero();
    for (const Contact& contact : std::span(slide.contacts).first(slide.contact_count)) {
        const Vec3 shaded = options_.properties->shaded_normal(contact.triangle, contact.point);
        if (shaded.isZero(0)) return Vec3::Zero();
        // The proxy may be on either side.
        smooth += contact.pressure * (shaded.dot(contact.normal) < 0 ? Vec3(-shaded) : shaded);
    }
    const double rise = smooth.dot(normal);
    constexpr double least = 0.5; // a mean beyond 60 degrees is of no use here
    if (!(rise > least * smooth.norm())) return Vec3::Zero();
    return depth * (smooth / rise - normal);
}

/// Slides aside as far as walls allow, and returns how far the spring leans. It does not lean in the
/// tick of the first contact.
Vec3 Proxy::lean_towards(const Vec3& p, ProxyTick& next) noexcept
{
    if (tick_.hold == Hold::free || tick_.slide.contact_count == 0) return Vec3::Zero();
    const SlideResult& slide = next.slide;
    Vec3 lean = shading_of(slide, next.normal, next.depth);
    if (lean.isZero(0)) return lean;
    const SlideResult aside = slide_sphere(surface_, options_.radius, tick_.proxy, p + lean,
                                           scratch_, SlideStart::touching, moves_left(next.moves));
    next.moves += aside.moves;
    next.proxy = aside.center;
    const double part = (aside.center - slide.center).dot(lean) / lean.squaredNorm();
    return std::clamp(part, 0.0, 1.0) * lean;
}

std::size_t Proxy::moves_left(std::size_t made) const noexcept
{
    return std::max(options_.max_moves - std::min(made, options_.max_moves),
                    options_.max_moves / 4);
}

SlideResult Proxy::slide_without_friction(const Vec3& p) noexcept
{
    const Vec3& start = tick_.proxy;
    const Vec3& frictionless = tick_.slide.center;
    const std::size_t moves = options_.max_moves;
    if (tick_.hold != Hold::free && frictionless != start) {
        SlideResult slide = slide_sphere(surface_, options_.radius, frictionless, p,
                                         frictionless_scratch_, SlideStart::touching, moves);
        // If this position is free, or far from the proxy, the proxy itself may still be in contact,
        // and friction may hold it there.
        const double depth = (slide.anchor - p).norm();
        const double apart = (slide.center - start).norm();
        const double leaning = options_.shading == ForceShading::on ? 2 : 0;
        if (slide.contact_count > 0 && depth > 0 &&
            apart <= (2 * friction_of(slide, 1).fixed + leaning) * depth) {
            scratch_.begin_path(start);
            return slide;
        }
        SlideResult held = pull_sphere(surface_, options_.radius, start, p, scratch_);
        if (held.contact_count > 0 && friction_of(held, grip_).fixed > 0) {
            scratch_.begin_path(start);
            held.center = start;
            held.moves = slide.moves;
            return held;
        }
    }
    const bool touched = tick_.hold != Hold::free && tick_.slide.contact_count > 0;
    const SlideStart known = touched ? SlideStart::touching : SlideStart::anywhere;
    return slide_sphere(surface_, options_.radius, start, p, scratch_, known, moves);
}

/// Holds the proxy, or lets it follow the target as far as friction allows. Normal and tangential
/// part of the pull are those at the proxy's own contacts: at the device a curved surface has another
/// normal.
void Proxy::hold_back(const Vec3& target, const Friction& friction, std::size_t met, Hold before,
                      ProxyTick& next) noexcept
{
    const Vec3 start = scratch_.path().front();
    const Vec3 gripped = scratch_.path()[met];
    const SlideResult pull = pull_sphere(surface_, options_.radius, gripped, target, scratch_);
    if (next.slide.contact_count == 0) {
        // The frictionless position is late on a free path. The proxy is so too, or is held.
        if (pull.contact_count == 0) return;
        next.slide.contacts = pull.contacts;
        next.slide.contact_count = pull.contact_count;
    }
    const double pressed = (pull.center - target).norm();
    const double slip = (pull.center - gripped).norm();
    const double part = before == Hold::sliding ? options_.restick : 1;
    if (slip <= part * friction.fixed * pressed) next.hold = Hold::sticking;
    const double trail = friction.sliding * pressed;
    if (next.hold == Hold::sticking || slip <= trail) {
        scratch_.cut_path(met);
        next.anchor = gripped + (pull.anchor - pull.center);
        next.proxy = gripped;
        if (next.slide.end == SlideEnd::limited) next.slide.end = SlideEnd::settled;
        return;
    }
    const SlideResult dragged =
        slide_sphere(surface_, options_.radius, start, target, scratch_, SlideStart::touching,
                     moves_left(next.moves), friction.sliding);
    next.moves += dragged.moves;
    next.proxy = dragged.center;
    if (next.slide.end == SlideEnd::limited) next.slide.end = dragged.end;
    next.anchor = dragged.contact_count > 0 ? dragged.anchor : dragged.center;
}

const ProxyTick& Proxy::follow(const Vec3& p) noexcept
{
    if (!tick_.is_placed && !find_free(p)) return tick_;
    const Hold before = tick_.slide.contact_count > 0 ? tick_.hold : Hold::free;
    const Vec3 start = tick_.proxy;
    const SlideResult slide = slide_without_friction(p);
    ProxyTick next;
    next.slide = slide;
    next.proxy = slide.center;
    next.anchor = slide.anchor;
    next.moves = slide.moves;
    const Vec3 back = slide.anchor - p;
    next.depth = back.norm();
    // A proxy that runs out of moves on a free path is late: the spring eases as it arrives.
    const bool touching = slide.contact_count > 0;
    const bool late = !touching && slide.end == SlideEnd::limited;
    if (!(next.depth > 0) || !(touching || late)) {
        tick_ = next;
        return tick_;
    }
    next.normal = back / next.depth;
    next.hold = Hold::sliding;
    if (late && before == Hold::free) {
        tick_ = next;
        return tick_;
    }
    // Friction begins at the first contact.
    const std::size_t met = before == Hold::free ? slide.first_contact : 0;
    const Vec3 lean = lean_towards(p, next);
    next.anchor += lean;
    const Friction friction = friction_of(slide, grip_);
    if (friction.fixed > 0) {
        hold_back(p + lean, friction, met, before, next);
    } else if (scratch_.path().back() != next.proxy) {
        // Without friction the proxy moves to the frictionless position.
        const SlideResult freed = slide_sphere(surface_, options_.radius, start, p, scratch_,
                                               SlideStart::touching, moves_left(next.moves));
        next.moves += freed.moves;
        next.proxy = freed.center;
    }
    tick_ = next;
    return tick_;
}

} // namespace proxima
