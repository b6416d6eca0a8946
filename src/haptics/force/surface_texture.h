// The force of a surface's texture (SurfaceTexture in touch_scene.h), tick by tick.
//
//     q device, p frictionless proxy, d = |p - q| its depth, n its normal, g(p) the groove's depth
//     e = max(d - g, 0)                        what is left of the depth
//     bump         K e n + K e T g'(p)         instead of K d n; T g' is the slope along the surface
//     viscosity    -b (v - v.n n)
//     stick-slip   k T (s - p), where the proxy stuck at s; beyond max_force s becomes p
//     tap          f n, after an impact
//
// Bump and stick-slip have a potential, U = K e^2 / 2 + k |s - p|^2 / 2, where the proxy's contacts are
// faces; jumps of the stick point only lessen it. An observer compares their work with it in each tick:
// what they give beyond it, over round edges or between different textures, is taken back by damping
// along the surface ([hannaford-2002]). What sampling and delay add is the passivity guard's to find,
// for which both are part of the spring.
//
// The tap alone gives energy by intent: an account of its own ends it at A v / (pi f) joules, what half
// a wave of its amplitude A gives at the speed of impact v.
#pragma once

#include "haptics/proxy/proxy.h"
#include "haptics/surface/surface_properties.h"
#include "proxima/device.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <cstdint>
#include <utility>

namespace proxima {

/// What a texture did in a session.
struct TextureReport {
    std::uint64_t slips = 0;        ///< jumps of the stick point
    std::uint64_t taps = 0;         ///< impacts with a transient
    std::uint64_t damped_ticks = 0; ///< in which the observer added damping
    double given = 0;               ///< J, by taps: the most of one
};

/// The texture under the proxy in a tick: parts of the spring and of the damper.
struct TextureTick {
    bool acts = false;
    bool presses = true;       ///< false: the device is in a groove, above its ground
    double grip = 1;           ///< e / d: the part of the contact's pressure that is left
    double groove = 0;         ///< m, d - e
    Vec3 along = Vec3::Zero(); ///< N, of bump and stick-slip along the surface
    Vec3 pull = Vec3::Zero();  ///< N, stick-slip's part of it
    double viscosity = 0;      ///< N s/m
    double added_damping = 0;  ///< N s/m along the surface, of the observer
    double stored = 0;         ///< J, beside what the spring alone stores
};

/// A tick of a textured contact.
struct TexturedContact {
    double stiffness = 0;         ///< N/m, mean of the contacts
    Vec3 position = Vec3::Zero(); ///< m, of the device relative to the surface
    Vec3 velocity = Vec3::Zero(); ///< m/s, relative to the surface
    Vec3 ground = Vec3::Zero();   ///< m, displacement by the touched surface
    double seconds = 1e-3;
    bool damps = false; ///< the observer may add damping
    bool taps = false;  ///< neither in a ramp nor softened
};

/// One per device. noexcept, no allocation, O(1).
class TextureForce {
public:
    /// `properties` may be null and must outlive it.
    TextureForce(SurfaceTexture own, const SurfaceProperties* properties,
                 const DeviceLimits& device, double units_per_metre) noexcept
        : own_(std::move(own)), properties_(properties), device_(device),
          units_per_metre_(units_per_metre)
    {}

    /// Whether something that the proxy touches has a texture, or has had one since it was free.
    [[nodiscard]] bool touches(const ProxyTick& proxy) const noexcept;

    /// The texture in a tick in which touches() is true.
    [[nodiscard]] TextureTick pass(const ProxyTick& proxy, const TexturedContact& contact) noexcept;

    /// The force of a tap along the normal in this tick, N. \pre after pass(), or release()
    [[nodiscard]] double tap() const noexcept { return tap_force_; }

    /// A tick in which touches() is false.
    void release(double seconds) noexcept;

    /// Starts anew.
    void reset() noexcept;

    [[nodiscard]] const TextureReport& report() const noexcept { return report_; }

private:
    [[nodiscard]] const SurfaceTexture& texture_of(const Contact& contact) const noexcept;
    void observe(TextureTick& tick, const Vec3& normal, const Vec3& step,
                 const TexturedContact& contact) noexcept;
    void advance_tap(const Tap& tap, bool presses, const Vec3& normal, const Vec3& step,
                     const TexturedContact& contact) noexcept;

    /// The impact that is felt.
    struct Impact {
        bool active = false;
        double amplitude = 0;      ///< N
        double frequency = 0;      ///< Hz
        double decay = 0;          ///< 1/s
        double seconds = 0;        ///< since then
        double most_given = 0;     ///< J
        double given = 0;          ///< J
        Vec3 force = Vec3::Zero(); ///< N, in the last tick
    };

    SurfaceTexture own_;
    const SurfaceProperties* properties_;
    DeviceLimits device_;
    double units_per_metre_;

    bool stuck_ = false;
    Vec3 stick_ = Vec3::Zero(); ///< m, relative to the surface

    bool observed_ = false;        ///< the last tick had a contact
    double energy_ = 0;            ///< J, taken beyond what is stored; never more than 0
    double stored_ = 0;            ///< J
    Vec3 position_ = Vec3::Zero(); ///< m
    Vec3 force_ = Vec3::Zero();    ///< N, of the potential and the observer

    double free_seconds_ = 0;
    Impact impact_;
    double tap_force_ = 0;
    TextureReport report_;
};

} // namespace proxima
