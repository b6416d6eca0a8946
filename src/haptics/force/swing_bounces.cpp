#include "haptics/force/swing_bounces.h"

namespace proxima {

/// Along the contact's push, m/s, in a span of ticks that ended so many ticks ago.
double BounceDetector::speed(std::size_t ago) const noexcept
{
    const Tick& end = at(ago);
    const Tick& begin = at(ago + span);
    return axis_.dot(end.position - begin.position) / (end.seconds - begin.seconds);
}

/// A contact begins, or goes on.
void BounceDetector::touch(const Vec3& along, const Vec3& surface_velocity) noexcept
{
    if (free_ticks_ < settling + span) return;
    // Both speeds are as far from the contact: then so is what a push changed of them.
    counts_ = free_ticks_ >= 2 * settling + span;
    if (!counts_) return;
    touching_ = 0;
    axis_ = along;
    last_ = {};
    last_.touched = true;
    last_.flight = flight_;
    last_.speed_in = along.dot(surface_velocity) - speed(settling);
}

Bounce BounceDetector::watch(const Vec3& position, const Vec3& force, const Vec3& surface_velocity,
                             double seconds, double most_force) noexcept
{
    const double time = at(0).seconds + seconds;
    ++now_;
    ticks_[now_ % kept] = {position, time};
    const double size = force.norm();
    flight_ += seconds;
    if (!(size > 0)) {
        ++free_ticks_;
        if (!counts_ || free_ticks_ != settling + span) return {};
        Bounce over = last_;
        over.touched = false;
        over.left = true;
        over.touching = touching_;
        over.speed_out = speed(0) - surface_speed_;
        return over;
    }
    const Vec3 along = force / size;
    constexpr double least_cosine = 0.8;
    Bounce result;
    if (free_ticks_ > 0) {
        touch(along, surface_velocity);
        if (counts_ && touching_ == 0) result = last_;
    }
    flight_ = 0;
    free_ticks_ = 0;
    counts_ = counts_ && along.dot(axis_) >= least_cosine;
    surface_speed_ = axis_.dot(surface_velocity);
    touching_ += seconds;
    last_.contact += size < most_force ? seconds : 0;
    return result;
}

} // namespace proxima
