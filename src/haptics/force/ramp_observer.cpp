#include "haptics/force/ramp_observer.h"

#include <algorithm>

namespace proxima {

Vec3 RampObserver::pass(const Vec3& position, const Vec3& velocity, const Vec3& force,
                        double seconds) noexcept
{
    if (running_) energy_ -= applied_.dot(position - position_);
    running_ = true;
    position_ = position;
    const double expected = energy_ - force.dot(velocity) * seconds;
    const double speed_squared = velocity.squaredNorm();
    if (!(expected < 0 && speed_squared > 0)) return force;
    return force - std::min(-expected / (seconds * speed_squared), max_damping_) * velocity;
}

} // namespace proxima
