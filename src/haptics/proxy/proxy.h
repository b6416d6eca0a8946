// The proxy: where the finger would be if it could not enter the object.
//
//     Proxy proxy(surface, {.radius = 0.002});
//     proxy.place(device);                            // once: its start
//     const ProxyTick& tick = proxy.follow(device);   // every tick
//     force = stiffness * (tick.anchor - device)
//
// A point (god-object, [zilles-1995]) or a sphere ([ruspini-1997]) that slides over the surface as
// near to the device as it can come (slide_sphere.h). Lengths are in the surface's own unit.
//
// Friction [melder-2004] is Coulomb's law at the proxy's own contacts: the spring pulls with a part
// that they take, N, and a part along them, T. The proxy sticks while |T| <= mu_s |N|, else it slides
// towards the device to |T| = mu_d |N|. So it follows the device along a tractrix, whatever the
// surface's curvature, and a device at rest leaves it at rest.
//
// The frictionless position, which tells depth and normal, moves on from the one of the last tick,
// for friction lets the proxy lag behind by many triangles.
//
// Force shading [ruspini-1997]: the goal is moved aside until the spring leans along the smooth
// surface's normal, and the proxy slides towards it over the true surface. It never enters, and
// where a wall stops it the spring leans less. The spring's part along the true normal stays.
#pragma once

#include "haptics/proxy/slide_sphere.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/surface_properties.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <cstdint>

namespace proxima {

struct ProxyOptions {
    double radius = 0;           ///< 0 = a point
    double static_friction = 0;  ///< mu_s
    double dynamic_friction = 0; ///< mu_d, at most mu_s
    double restick = 0.6;        ///< sliding ends below this part of mu_s
    /// Moves of the first slide of a tick at most. Further slides of the tick may make at least a
    /// quarter as many. A slide that runs out of moves continues in the next tick.
    std::size_t max_moves = max_slide_moves;
    ForceShading shading = ForceShading::off;
    /// Frictions and normals by triangle; must outlive the proxy.
    const SurfaceProperties* properties = nullptr;
};

/// The result of a tick. Lengths in the surface's unit.
struct ProxyTick {
    Vec3 proxy = Vec3::Zero();  ///< the centre
    Vec3 anchor = Vec3::Zero(); ///< what a spring pulls the device to; the device where free
    Hold hold = Hold::free;
    Vec3 normal = Vec3::Zero(); ///< of all contacts together, of length 1; zero where free
    double depth = 0;           ///< of the device below the frictionless position
    bool is_placed = true;      ///< false: no free position is near, and nothing is touched
    SlideResult slide;          ///< without friction; `end` is of the proxy's own motion
    std::size_t moves = 0;      ///< of all slides of this tick
};

/// Refers to the surface, which must outlive it. One thread at a time. All but the constructor are
/// noexcept, without allocation, and make a few queries of the surface.
class Proxy {
public:
    /// \pre radius >= 0, 0 <= dynamic_friction <= static_friction, all finite, 4 <= max_moves <=
    /// max_slide_moves
    Proxy(const ContactSurface& surface, const ProxyOptions& options);

    [[nodiscard]] const ProxyOptions& options() const noexcept { return options_; }

    /// The sphere's radius: never less than the safety gap.
    [[nodiscard]] double radius() const noexcept { return radius_; }

    /// Starts at the device, or at the free position nearest to it (free_position.h), in up to
    /// 0.2 ms. Where none is within four radii the proxy is not placed: it is at the device and
    /// touches nothing until the device is at a free position. \pre p is finite
    void place(const Vec3& p) noexcept;

    /// Moves the proxy and the frictionless position (last().slide.center) with objects that moved.
    /// \pre placed, and both paths pass nothing (move_with_objects.h)
    void carry(const Vec3& to, const Vec3& without_friction) noexcept
    {
        tick_.proxy = to;
        tick_.slide.center = without_friction;
    }

    /// The part of the contact's pressure that friction counts from the next tick on: 1 but for
    /// surfaces with grooves. \pre 0 <= part <= 1
    void set_grip(double part) noexcept { grip_ = part; }

    /// A tick in which the proxy is not placed. \pre p is finite
    const ProxyTick& wait(const Vec3& p) noexcept;

    /// A tick in which the proxy follows the device. \pre place() was called; p is finite
    const ProxyTick& follow(const Vec3& p) noexcept;

    [[nodiscard]] const ProxyTick& last() const noexcept { return tick_; }

    struct Friction {
        double fixed = 0;
        double sliding = 0;
    };
    /// At the last tick's contacts, a mean by pressure, as if set_grip() had given 1.
    [[nodiscard]] Friction friction_without_grip() const noexcept
    {
        return friction_of(tick_.slide, 1);
    }

    /// The centre's positions in the last tick, with straight moves between them.
    [[nodiscard]] std::span<const Vec3> path() const noexcept
    {
        return tick_.is_placed ? scratch_.path() : std::span<const Vec3>();
    }

    /// Work counters of all ticks.
    [[nodiscard]] ContactWork work() const noexcept
    {
        return scratch_.work() + frictionless_scratch_.work();
    }

private:
    [[nodiscard]] Friction friction_of(const SlideResult& slide, double grip) const noexcept;
    [[nodiscard]] Vec3 shading_of(const SlideResult& slide, const Vec3& normal,
                                  double depth) const noexcept;
    [[nodiscard]] bool find_free(const Vec3& p) noexcept;
    [[nodiscard]] std::size_t moves_left(std::size_t made) const noexcept;
    [[nodiscard]] SlideResult slide_without_friction(const Vec3& p) noexcept;
    [[nodiscard]] Vec3 lean_towards(const Vec3& p, ProxyTick& next) noexcept;
    void hold_back(const Vec3& target, const Friction& friction, std::size_t met, Hold before,
                   ProxyTick& next) noexcept;

    const ContactSurface& surface_;
    ProxyOptions options_;
    double radius_;
    double grip_ = 1;
    SlideScratch scratch_;
    SlideScratch frictionless_scratch_; ///< of the frictionless position where friction parts them
    ProxyTick tick_;
};

} // namespace proxima
