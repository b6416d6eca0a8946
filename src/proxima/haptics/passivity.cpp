#include "proxima/haptics/passivity.h"

#include <algorithm>

namespace proxima {

Vec3 PassivityGuard::pass(const Vec3& position, const Vec3& velocity, const Vec3& force,
                          double seconds) noexcept
{
    if (running_) energy_ -= last_force_.dot(position - last_position_);
    running_ = true;
    lowest_ = std::min(lowest_, energy_);
    last_position_ = position;
    last_force_ = force;
    const double speed_squared = velocity.squaredNorm();
    const double expected = energy_ - force.dot(velocity) * seconds;
    if (expected < 0 && speed_squared > 0) {
        const double alpha = std::min(-expected / (seconds * speed_squared), max_damping_);
        last_force_ -= alpha * velocity;
        ++damped_;
    }
    return last_force_;
}

void PassivityGuard::restart() noexcept
{
    energy_ = 0;
    running_ = false;
}

} // namespace proxima
