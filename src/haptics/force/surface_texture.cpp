#include "haptics/force/surface_texture.h"

#include "haptics/surface/height_field.h"
#include "haptics/surface/wave.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace proxima {

namespace {

/// s without a contact before another impact counts: a device that flutters at the surface is not
/// tapped.
constexpr double least_free_seconds = 0.02;
constexpr double least_impact = 0.01;  ///< m/s
constexpr double most_impact = 1;      ///< m/s: faster velocities are noise of the device
constexpr double tap_end = 0.02;       ///< part of the amplitude at which a tap ends
constexpr double most_sampled = 0.4;   ///< waves per tick
constexpr double reported_part = 0.01; ///< of the device's damping

std::span<const Contact> contacts_of(const ProxyTick& proxy) noexcept
{
    return std::span(proxy.slide.contacts).first(proxy.slide.contact_count);
}

/// The part of v along all contacts: how the frictionless proxy follows.
Vec3 along_contacts(const ProxyTick& proxy, const Vec3& v) noexcept
{
    constexpr double least_corner = 1e-6; // sine of the angle of two normals
    const auto contacts = contacts_of(proxy);
    if (contacts.size() == 3) return Vec3::Zero();
    if (contacts.size() == 2) {
        const Vec3 edge = contacts[0].normal.cross(contacts[1].normal);
        const double length = edge.norm();
        if (length > least_corner) return v.dot(edge) / (length * length) * edge;
    }
    return v - v.dot(proxy.normal) * proxy.normal;
}

} // namespace

const SurfaceTexture& TextureForce::texture_of(const Contact& contact) const noexcept
{
    const SurfaceTexture* const texture =
        properties_ != nullptr ? properties_->texture(contact.triangle) : nullptr;
    return texture != nullptr ? *texture : own_;
}

bool TextureForce::touches(const ProxyTick& proxy) const noexcept
{
    if (proxy.hold == Hold::free || !(proxy.depth > 0)) return false;
    // A contact that leaves a texture settles its account where there is none.
    return observed_ || std::ranges::any_of(contacts_of(proxy), [&](const Contact& contact) {
               return texture_of(contact).any();
           });
}

TextureTick TextureForce::pass(const ProxyTick& proxy, const TexturedContact& contact) noexcept
{
    // Where several surfaces are touched each has a part by its pressure.
    double pressures = 0;
    Groove groove;
    StickSlip stick_slip;
    Tap tap{.gain = 0, .frequency = 0, .decay = 0};
    TextureTick tick{.acts = true};
    for (const Contact& each : contacts_of(proxy)) {
        const SurfaceTexture& texture = texture_of(each);
        const TextureStrengths strengths = limited_strengths(texture, contact.stiffness, device_);
        const double part = each.pressure;
        pressures += part;
        tick.viscosity += part * strengths.viscosity;
        if (strengths.stick_slip.any()) {
            stick_slip.stiffness += part * strengths.stick_slip.stiffness;
            stick_slip.max_force += part * strengths.stick_slip.max_force;
        }
        tap.gain += part * strengths.tap.gain;
        tap.frequency += part * strengths.tap.frequency;
        tap.decay += part * strengths.tap.decay;
        if (!texture.bump.any()) continue;
        const RigidTransform pose =
            properties_ != nullptr ? properties_->pose(each.triangle) : RigidTransform{};
        const Vec3 local = pose.rotation.transpose() * (each.point - pose.translation);
        const Groove own = groove_at(texture.bump, strengths.amplitude, local / units_per_metre_);
        groove.depth += part * own.depth;
        groove.slope += part * (pose.rotation * own.slope);
    }
    if (!(pressures > 0)) {
        release(contact.seconds);
        return {};
    }
    const double depth = proxy.depth / units_per_metre_;
    const double left = std::max(depth - groove.depth / pressures, 0.0);
    tick.presses = left > 0;
    tick.grip = std::min(left / depth, 1.0);
    tick.groove = depth - left;
    tick.viscosity = tick.presses ? tick.viscosity / pressures : 0;
    tick.along = contact.stiffness * left * along_contacts(proxy, groove.slope / pressures);
    tick.stored = 0.5 * contact.stiffness * (left * left - depth * depth);
    const double stiffness = stick_slip.stiffness / pressures;
    if (stick_slip.any() && tick.presses) {
        const Vec3 there = proxy.slide.center / units_per_metre_ - contact.ground;
        if (!stuck_) stick_ = there;
        stuck_ = true;
        const Vec3 pull = stiffness * along_contacts(proxy, stick_ - there);
        if (pull.norm() > stick_slip.max_force / pressures) {
            stick_ = there;
            ++report_.slips;
        } else {
            tick.pull = pull;
            tick.along += pull;
            tick.stored += 0.5 * stiffness * (stick_ - there).squaredNorm();
        }
    } else {
        stuck_ = false;
    }
    const Vec3 step = observed_ ? Vec3(contact.position - position_) : Vec3(Vec3::Zero());
    observe(tick, proxy.normal, step, contact);
    tap = {tap.gain / pressures, tap.frequency / pressures, tap.decay / pressures};
    advance_tap(tap, tick.presses, proxy.normal, step, contact);
    return tick;
}

/// Damps along the surface what the texture gave beyond its potential. The force between two ticks is
/// the mean of theirs: what holding it for a tick adds is the passivity guard's.
void TextureForce::observe(TextureTick& tick, const Vec3& normal, const Vec3& step,
                           const TexturedContact& contact) noexcept
{
    Vec3 force = tick.along - contact.stiffness * tick.groove * normal;
    const Vec3 along = contact.velocity - contact.velocity.dot(normal) * normal;
    if (observed_) {
        const double taken = -0.5 * (force_ + force).dot(step);
        energy_ = std::min(energy_ + taken - (tick.stored - stored_), 0.0);
        const double speed_squared = along.squaredNorm();
        if (energy_ < 0 && speed_squared > 0 && contact.damps) {
            tick.added_damping = std::min(-energy_ / (contact.seconds * speed_squared),
                                          most_texture_damping(device_));
            force -= 2 * tick.added_damping * along; // in the mean, all of it in one tick
            report_.damped_ticks +=
                tick.added_damping > reported_part * device_.max_damping ? 1U : 0U;
        }
    }
    observed_ = true;
    stored_ = tick.stored;
    position_ = contact.position;
    force_ = force;
}

/// A tap begins with an impact, and ends as it fades, with the contact, or with its energy.
void TextureForce::advance_tap(const Tap& tap, bool presses, const Vec3& normal, const Vec3& step,
                               const TexturedContact& contact) noexcept
{
    const double speed = std::min(-contact.velocity.dot(normal), most_impact);
    if (presses && free_seconds_ >= least_free_seconds && tap.any() && contact.taps &&
        speed >= least_impact) {
        const double amplitude = std::min(tap.gain * speed, 0.5 * device_.max_force);
        const double frequency = std::min(tap.frequency, most_sampled / contact.seconds);
        impact_ = {.active = true,
                   .amplitude = amplitude,
                   .frequency = frequency,
                   .decay = tap.decay,
                   .most_given = amplitude * speed / (std::numbers::pi * frequency)};
        ++report_.taps;
    } else if (impact_.active) {
        impact_.seconds += contact.seconds;
    }
    if (presses) free_seconds_ = 0;
    tap_force_ = 0;
    if (!impact_.active) return;
    const double left = decay_of(std::min(impact_.decay * impact_.seconds, 64.0));
    if (!presses || !contact.taps || left < tap_end) {
        impact_.active = false;
        return;
    }
    impact_.given += impact_.force.dot(step);
    report_.given = std::max(report_.given, impact_.given);
    const double force =
        impact_.amplitude * left * wave_at(impact_.frequency * impact_.seconds).sine;
    const double next = impact_.given + force * contact.velocity.dot(normal) * contact.seconds;
    if (next > impact_.most_given) {
        impact_.active = false;
        return;
    }
    tap_force_ = force;
    impact_.force = force * normal;
}

void TextureForce::release(double seconds) noexcept
{
    stuck_ = false;
    observed_ = false;
    energy_ = 0;
    free_seconds_ = std::min(free_seconds_ + seconds, 1.0);
    impact_.active = false;
    tap_force_ = 0;
}

void TextureForce::reset() noexcept
{
    release(0);
    free_seconds_ = 0;
    report_ = {};
}

} // namespace proxima
