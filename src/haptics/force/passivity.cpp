#include "haptics/force/passivity.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

constexpr double least_softness = 1e-3;
constexpr double first_recovery = 8; ///< s, in which s doubles after the first oscillation
constexpr double longest_recovery = 512;
constexpr double fading_damping = 3; ///< of all damping over sqrt(s): from s = 0.09 on it is less

} // namespace

double PassivityGuard::added_damping() const noexcept
{
    return max_damping_ * (1 - softness_) * std::sqrt(softness_);
}

/// Softens the force, by more the faster an oscillation grew.
void PassivityGuard::soften(double growth) noexcept
{
    softness_ = std::max(softness_ * std::clamp(std::exp(-1.5 * growth), 0.1, 0.6), least_softness);
    softest_ = std::min(softest_, softness_);
    recovery_ = std::clamp(2 * recovery_, first_recovery, longest_recovery);
}

void PassivityGuard::recover(double seconds) noexcept
{
    if (softness_ >= 1) return;
    ++softened_;
    softness_ = std::min(softness_ * std::exp2(seconds / recovery_), 1.0);
    if (softness_ >= 1) recovery_ = 0;
}

/// The most damping that the observer may add beside that of the wall and of softening. It vanishes
/// with s: where a wall that is almost gone still oscillates, damping may be the cause.
double PassivityGuard::most_alpha() const noexcept
{
    if (softness_ >= 1) return max_damping_;
    const double bearable = std::min(1 - softness_, fading_damping * std::sqrt(softness_));
    return std::max(max_damping_ * bearable - added_damping(), 0.0);
}

/// Scales and damps the force. Damping never makes it pull the other way.
Vec3 PassivityGuard::softened(const Vec3& force, const Vec3& velocity) const noexcept
{
    if (softness_ >= 1) return force;
    const double size = force.norm();
    if (!(size > 0)) return force;
    const Vec3 along = force / size;
    const Vec3 damping = -added_damping() * velocity;
    const double pull = std::min(damping.dot(along) + softness_ * size, 0.0);
    return softness_ * force + damping - pull * along;
}

Vec3 PassivityGuard::pass(const Vec3& position, const Vec3& velocity, const Vec3& force,
                          double seconds) noexcept
{
    recover(seconds);
    const double growth = oscillations_.watch(position, force, seconds);
    if (growth > 0) soften(growth);
    const Vec3 wanted = softened(force, velocity);
    if (running_) energy_ -= last_force_.dot(position - last_position_);
    running_ = true;
    lowest_ = std::min(lowest_, energy_);
    last_position_ = position;
    last_force_ = wanted;
    const double speed_squared = velocity.squaredNorm();
    const double expected = energy_ - wanted.dot(velocity) * seconds;
    if (expected < 0 && speed_squared > 0) {
        const double alpha = std::min(-expected / (seconds * speed_squared), most_alpha());
        last_force_ -= alpha * velocity;
        ++damped_;
    }
    return last_force_;
}

void PassivityGuard::leave(const Vec3& position, double seconds) noexcept
{
    recover(seconds);
    const double growth = oscillations_.watch(position, Vec3::Zero(), seconds);
    if (growth > 0) soften(growth);
    reset_energy();
}

void PassivityGuard::reset_energy() noexcept
{
    energy_ = 0;
    running_ = false;
}

void PassivityGuard::restart() noexcept
{
    reset_energy();
    oscillations_.restart();
}

} // namespace proxima
