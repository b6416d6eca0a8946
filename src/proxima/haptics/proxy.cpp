#include "proxima/haptics/proxy.h"

#include "proxima/base/check.h"
#include <algorithm>
#include <cmath>

namespace proxima {

Proxy::Proxy(const ContactSurface& surface, const ProxyOptions& options)
    : surface_(surface), options_(options),
      radius_(std::max(options.radius, safety_gap(surface.scale())))
{
    PROXIMA_CHECK_GE(options.radius, 0);
    PROXIMA_CHECK_GE(options.dynamic_friction, 0);
    PROXIMA_CHECK_LE(options.dynamic_friction, options.static_friction);
    PROXIMA_CHECK_GE(options.max_moves, 4U);
    PROXIMA_CHECK_LE(options.max_moves, max_slide_moves);
}

void Proxy::place(const Vec3& p) noexcept
{
    tick_ = {};
    tick_.proxy = tick_.held = p;
    free_from_surface();
}

void Proxy::free_from_surface() noexcept
{
    // Away from the nearest triangle until nothing is near; in a narrow place the next nearest
    // pushes back, and the last place will do: sweeps treat what is too near as touched.
    constexpr int attempts = 16;
    for (int attempt = 0; attempt < attempts; ++attempt) {
        const Vec3& p = tick_.proxy;
        if (surface_.clearance(p) > radius_) return;
        const auto near = nearest_contact(surface_, p, radius_, room_);
        if (!near) return;
        tick_.proxy = near->point + near->normal * (radius_ * (1 + 0x1p-20));
    }
}

bool Proxy::sticks(double aside, double depth) const noexcept
{
    const bool slid = tick_.hold == Hold::sliding;
    const double most = slid ? options_.restick * options_.static_friction * depth
                             : options_.static_friction * depth;
    return aside <= most;
}

std::size_t Proxy::moves_left(std::size_t made) const noexcept
{
    return std::max(options_.max_moves - std::min(made, options_.max_moves),
                    options_.max_moves / 4);
}

SlideResult Proxy::slide_easily(const Vec3& p) noexcept
{
    const Vec3& start = tick_.proxy;
    const Vec3& easy = tick_.slide.center;
    const std::size_t moves = options_.max_moves;
    if (tick_.hold != Hold::free && easy != start) {
        const SlideResult slide = slide_sphere(surface_, options_.radius, easy, p, easy_room_,
                                               SlideStart::touching, moves);
        // Where it has come loose or far away from the proxy, the proxy may still be held back.
        const double depth = (slide.held - p).norm();
        const double apart = (slide.center - start).norm();
        if (slide.contact_count > 0 && depth > 0 && apart <= 2 * options_.static_friction * depth) {
            room_.begin_path(start);
            return slide;
        }
    }
    const SlideStart known = tick_.hold == Hold::free ? SlideStart::anywhere : SlideStart::touching;
    return slide_sphere(surface_, options_.radius, start, p, room_, known, moves);
}

const ProxyTick& Proxy::follow(const Vec3& p) noexcept
{
    const Hold before = tick_.hold;
    const Vec3 start = tick_.proxy;
    const SlideResult slide = slide_easily(p);
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
    if (options_.static_friction > 0) {
        // Friction begins where the surface was met first.
        const std::size_t met = before == Hold::free ? slide.first_contact : 0;
        const Vec3 anchor = room_.path()[met];
        Vec3 aside = anchor - slide.center;
        aside -= next.normal * next.normal.dot(aside);
        const double distance = aside.norm();
        if (sticks(distance, next.depth)) next.hold = Hold::sticking;
        const double trail = options_.dynamic_friction * next.depth;
        if (next.hold == Hold::sticking || distance <= trail) {
            room_.cut_path(met);
            next.proxy = anchor;
            next.held = slide.held + (anchor - slide.center);
        } else {
            const Vec3 lag = aside * (trail / distance);
            const std::size_t moves = moves_left(slide.moves);
            const SlideResult dragged = slide_sphere(surface_, options_.radius, start, p + lag,
                                                     room_, SlideStart::touching, moves);
            next.moves += dragged.moves;
            next.proxy = dragged.center;
            next.held = dragged.contact_count > 0 ? dragged.held : dragged.center;
        }
    }
    tick_ = next;
    return tick_;
}

} // namespace proxima
