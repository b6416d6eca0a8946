#include "haptics/force/swing_detector.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

constexpr double least_leg = 1.5e-4; ///< m: three steps of the coarsest encoder
/// s: half a period of 20 Hz. Hands tap at 10 Hz and tremble at 12 Hz at most.
constexpr double fast_leg = 0.025;
/// m/s^2, length over time squared: half a sine of that has a peak of pi^2 / 2 as much, 60 m/s^2, which
/// is six times gravity and three times that of taps of 10 mm at 10 Hz.
constexpr double fast_acceleration = 12;
constexpr double same_axis = 0.8;        ///< cosine: legs along another axis begin anew
constexpr double least_first_leg = 1e-3; ///< m: of a fast leg that none was before
constexpr double again = 1.5;            ///< a leg is reported again at each such factor of growth

bool is_fast_leg(double length, double seconds) noexcept
{
    return seconds <= fast_leg || length >= fast_acceleration * seconds * seconds;
}

} // namespace

/// The motion turned: the leg that ends is the one to compare with.
void SwingDetector::end_leg() noexcept
{
    const double length = std::abs(farthest_ - turned_);
    const bool counts = farthest_seconds_ <= longest_leg;
    // The first leg began before the contact, who knows where.
    const double amplitude = counts && !first_leg_ ? std::min(length, last_leg_) : 0;
    first_leg_ = last_leg_ == 0;
    legs_ = amplitude > 0 && amplitude >= amplitude_ && amplitude_ > 0 ? legs_ + 1 : 0;
    last_leg_ = counts ? length : 0;
    amplitude_ = amplitude;
    last_fast_ = is_fast_leg(length, farthest_seconds_);
    turned_ = farthest_;
    direction_ = -direction_;
    leg_seconds_ -= farthest_seconds_;
    cycle_contact_ = last_contact_ + contact_;
    last_contact_ = contact_;
    contact_ = 0;
    next_ = 1;
}

SwingTick SwingDetector::watch(const Vec3& position, const Vec3& force, double seconds,
                               double most_force) noexcept
{
    const double size = force.norm();
    const Vec3 step = position - last_;
    last_ = position;
    if (size > 0) {
        // The force of the other side of a slot is along the same axis.
        const Vec3 along = force / size;
        const double turn = along.dot(axis_);
        axis_ = turn < 0 ? Vec3(-along) : along;
        if (is_away() || std::abs(turn) < same_axis) {
            restart();
            axis_ = along;
            last_ = position;
            since_contact_ = 0;
            return {};
        }
        since_contact_ = 0;
    } else {
        since_contact_ += seconds;
    }
    if (is_away()) return {};

    SwingTick tick;
    height_ += axis_.dot(step);
    leg_seconds_ += seconds;
    contact_ += size > 0 && size < most_force ? seconds : 0;
    if (direction_ == 0) {
        if (std::abs(height_) < least_leg) return {};
        direction_ = height_ > 0 ? 1 : -1;
        farthest_ = height_;
        farthest_seconds_ = leg_seconds_;
    } else if (direction_ * (height_ - farthest_) > 0) {
        farthest_ = height_;
        farthest_seconds_ = leg_seconds_;
    } else if (direction_ * (farthest_ - height_) > least_leg) {
        end_leg();
        farthest_ = height_;
        farthest_seconds_ = leg_seconds_;
        tick.turned = true;
    }
    const double length = std::abs(farthest_ - turned_);
    // The second leg in contact has no amplitude before it: the first leg is one if it was fast.
    const double least = fast_acceleration * leg_seconds_ * leg_seconds_;
    const bool second = !(amplitude_ > 0) && size > 0 && last_fast_ && last_leg_ > least_first_leg;
    const double before = second ? again * last_leg_ : amplitude_;
    if (!(before > 0) || leg_seconds_ > longest_leg || length < next_ * before) return tick;
    tick.reported = true;
    tick.length = length;
    tick.contact = std::max(cycle_contact_, last_contact_ + contact_);
    tick.growth = length / (second ? last_leg_ : amplitude_);
    tick.legs = legs_ + 1 + static_cast<int>(std::log(tick.growth) / std::log(again));
    tick.fast = last_fast_ && is_fast_leg(length, leg_seconds_);
    tick.quick = tick.fast && tick.growth >= again && length >= least;
    while (length >= next_ * before) next_ *= again;
    return tick;
}

} // namespace proxima
