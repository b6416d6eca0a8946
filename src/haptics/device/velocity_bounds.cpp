#include "haptics/device/velocity_bounds.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

constexpr double least_margin = 0.005; ///< m/s
constexpr double longest_step = 1e-4;  ///< m: no encoder is coarser

} // namespace

void VelocityBounds::add(const Vec3& position, double seconds) noexcept
{
    if (placed_) {
        const Vec3 displacement = position - last_position_;
        for (const double moved :
             {std::abs(displacement.x()), std::abs(displacement.y()), std::abs(displacement.z())}) {
            if (moved > 0) step_ = std::min(step_ > 0 ? step_ : longest_step, moved);
        }
        velocities_[count_ % samples] = displacement / seconds;
        ++count_;
    }
    seconds_ = seconds;
    placed_ = true;
    last_position_ = position;
}

Vec3 VelocityBounds::plausible(const Vec3& reported) const noexcept
{
    if (!reported.allFinite()) return Vec3::Zero();
    Vec3 low = Vec3::Zero();
    Vec3 high = Vec3::Zero();
    Vec3 margin = Vec3::Constant(least_margin + 3 * step_ / seconds_);
    const std::size_t known = std::min(count_, samples);
    if (known > 0) low = high = velocities_[0];
    Vec3 change = Vec3::Zero();
    if (known > 0 && count_ <= samples) change = velocities_[0].cwiseAbs();
    for (std::size_t i = 1; i < known; ++i) {
        low = low.cwiseMin(velocities_[i]);
        high = high.cwiseMax(velocities_[i]);
        const Vec3& before = velocities_[(count_ - 1 - i) % samples];
        change = change.cwiseMax((velocities_[(count_ - i) % samples] - before).cwiseAbs());
    }
    margin += change;
    const bool is_plausible = (reported.array() >= (low - margin).array()).all() &&
                              (reported.array() <= (high + margin).array()).all();
    if (is_plausible) return reported;
    return known > 0 ? velocities_[(count_ - 1) % samples] : Vec3(Vec3::Zero());
}

} // namespace proxima
