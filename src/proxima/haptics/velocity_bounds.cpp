#include "proxima/haptics/velocity_bounds.h"

#include <algorithm>

namespace proxima {

namespace {

constexpr double least_room = 0.005; ///< m/s

} // namespace

void VelocityBounds::add(const Vec3& place, double seconds) noexcept
{
    if (placed_) {
        velocities_[count_ % samples] = (place - last_place_) / seconds;
        ++count_;
    }
    placed_ = true;
    last_place_ = place;
}

Vec3 VelocityBounds::believed(const Vec3& said) const noexcept
{
    if (!said.allFinite()) return Vec3::Zero();
    Vec3 low = Vec3::Zero();
    Vec3 high = Vec3::Zero();
    Vec3 room = Vec3::Constant(least_room);
    const std::size_t known = std::min(count_, samples);
    if (known > 0) low = high = velocities_[0];
    Vec3 change = Vec3::Zero();
    for (std::size_t i = 1; i < known; ++i) {
        low = low.cwiseMin(velocities_[i]);
        high = high.cwiseMax(velocities_[i]);
        const Vec3& before = velocities_[(count_ - 1 - i) % samples];
        change = change.cwiseMax((velocities_[(count_ - i) % samples] - before).cwiseAbs());
    }
    room += change;
    const bool borne = (said.array() >= (low - room).array()).all() &&
                       (said.array() <= (high + room).array()).all();
    if (borne) return said;
    return known > 0 ? velocities_[(count_ - 1) % samples] : Vec3(Vec3::Zero());
}

} // namespace proxima
