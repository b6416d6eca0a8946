#include "haptics/force/contact_force.h"

#include "base/check.h"
#include "geometry/length.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// Advances a ramp by a tick; a whole rise takes `whole` seconds.
double ramped(double value, double seconds, double whole, int direction) noexcept
{
    if (!(whole > 0)) return direction > 0 ? 1.0 : 0.0;
    return std::clamp(value + direction * seconds / whole, 0.0, 1.0);
}

} // namespace

Vec3 shortened(const Vec3& v, double most) noexcept
{
    const double length = length_of(v);
    if (length <= most) return v;
    Vec3 result = v * (most / length);
    while (result.norm() > most) result *= 1 - 0x1p-50;
    return result;
}

ForceOptions limited(ForceOptions options, const DeviceLimits& limits) noexcept
{
    options.stiffness = std::min(options.stiffness, limits.max_stiffness);
    options.damping = std::min(options.damping, limits.max_damping);
    return options;
}

Vec3 spring_force(const ForceOptions& options, const SpringContact& contact,
                  const Vec3& velocity) noexcept
{
    if (!contact.touching) return Vec3::Zero();
    const Vec3 spring = options.stiffness * contact.stretch;
    const double pressed = spring.dot(contact.normal);
    const double damped = -options.damping * velocity.dot(contact.normal);
    return spring + std::max(damped, -std::max(pressed, 0.0)) * contact.normal;
}

Vec3 penalty_force(const ForceOptions& options, double depth, const Vec3& normal,
                   const Vec3& velocity) noexcept
{
    return spring_force(options, {depth > 0, depth * normal, normal}, velocity);
}

ForceGuard::ForceGuard(const ForceOptions& options, double max_force) noexcept
    : options_(options), max_force_(max_force)
{
    PROXIMA_CHECK_GT(max_force, 0);
    restart();
}

void ForceGuard::restart() noexcept
{
    start_ = options_.start_seconds > 0 ? 0.0 : 1.0;
    patch_ = 1;
    fade_ = 0;
    last_ = Vec3::Zero();
}

void ForceGuard::cross_over() noexcept
{
    start_ = options_.start_seconds > 0 ? 0.0 : 1.0;
    fading_ = last_;
    fade_ = 1;
}

Vec3 ForceGuard::pass(const Vec3& wanted, double seconds, Patch patch) noexcept
{
    const double tick = std::isfinite(seconds) ? std::max(seconds, 0.0) : 0.0;
    Vec3 force = wanted;
    if (!wanted.allFinite()) {
        ++refused_;
        force = Vec3::Zero();
    }
    start_ = ramped(start_, tick, options_.start_seconds, 1);
    patch_ = ramped(patch_, tick, options_.loss_seconds, patch == Patch::lost ? -1 : 1);
    force *= start_ * patch_;
    if (fade_ > 0) {
        fade_ = ramped(fade_, tick, options_.loss_seconds, -1);
        force += fade_ * fading_;
    }
    const Vec3 within = shortened(force, max_force_);
    clamped_ += within != force ? 1U : 0U;
    const Vec3 step = within - last_;
    const Vec3 small = shortened(step, options_.max_slew * tick);
    const bool slews = small != step;
    slewed_ += slews ? 1U : 0U;
    // A force between two forces within the limit exceeds it by rounding only.
    last_ = slews ? shortened(last_ + small, max_force_) : within;
    return last_;
}

} // namespace proxima
