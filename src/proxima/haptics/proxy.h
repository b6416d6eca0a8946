// The proxy: where the finger would be if it could not enter the object.
//
//     Proxy proxy(surface, {.radius = 0.002});
//     proxy.place(device);                            // once: where it begins
//     const ProxyTick& tick = proxy.follow(device);   // every tick
//     force = stiffness * (tick.held - device)
//
// A point (god-object, [zilles-1995]) or a sphere ([ruspini-1997]) that slides over the surface as
// near to the device as it can come (slide_sphere.h), with a friction cone ([melder-2004]): while
// the way to the frictionless place is less than mu_s times the depth it stays where it is, else it
// follows to mu_d times the depth. The frictionless place goes on from where it was in the tick
// before, not from the proxy, which lags behind by many triangles: a short way instead of a long
// one. All in the surface's own unit.
#pragma once

#include "proxima/haptics/slide_sphere.h"

#include <cstdint>

namespace proxima {

struct ProxyOptions {
    double radius = 0;           ///< 0 = a point
    double static_friction = 0;  ///< mu_s
    double dynamic_friction = 0; ///< mu_d, at most mu_s
    double restick = 0.6;        ///< sliding ends below this part of mu_s
    /// Of a tick's first slide, and at least a quarter of it for another one: what is left of a
    /// way goes on in the next tick.
    std::size_t max_moves = max_slide_moves;
};

/// How the proxy is held.
enum class Hold : std::uint8_t { free, sliding, sticking };

struct ProxyTick {
    Vec3 proxy = Vec3::Zero(); ///< the centre
    Vec3 held = Vec3::Zero();  ///< what a spring pulls the device to; the device where free
    Hold hold = Hold::free;
    Vec3 normal = Vec3::Zero(); ///< of all contacts together, of length 1; zero where free
    double depth = 0;           ///< of the device below the frictionless place
    SlideResult slide;          ///< without friction
    std::size_t moves = 0;      ///< of all slides of this tick
};

/// Refers to the surface, which must outlive it. One thread at a time. All but the constructor are
/// noexcept, without allocation, and take a few questions of the surface.
class Proxy {
public:
    /// \pre radius >= 0, 0 <= dynamic_friction <= static_friction, all finite, 4 <= max_moves <=
    /// max_slide_moves
    Proxy(const ContactSurface& surface, const ProxyOptions& options);

    [[nodiscard]] const ProxyOptions& options() const noexcept { return options_; }

    /// The sphere's radius: never less than the safety gap.
    [[nodiscard]] double radius() const noexcept { return radius_; }

    /// Begins at the device, or where it is nearer to the surface than the radius, beside it: at
    /// the first place along the way from the nearest triangle that is free. \pre p is finite
    void place(const Vec3& p) noexcept;

    /// Follows the device by one tick. \pre placed; p is finite
    const ProxyTick& follow(const Vec3& p) noexcept;

    [[nodiscard]] const ProxyTick& last() const noexcept { return tick_; }

    /// The centre's places in the last tick, straight moves between them.
    [[nodiscard]] std::span<const Vec3> path() const noexcept { return room_.path(); }

    /// What all ticks asked the surface for.
    [[nodiscard]] ContactWork work() const noexcept { return room_.work() + easy_room_.work(); }

private:
    [[nodiscard]] bool sticks(double aside, double depth) const noexcept;
    [[nodiscard]] std::size_t moves_left(std::size_t made) const noexcept;
    [[nodiscard]] SlideResult slide_easily(const Vec3& p) noexcept;
    void free_from_surface() noexcept;

    const ContactSurface& surface_;
    ProxyOptions options_;
    double radius_;
    SlideRoom room_;
    SlideRoom easy_room_; ///< of the frictionless place, where that is another
    ProxyTick tick_;
};

} // namespace proxima
