#include "haptics/force/swing_bounces.h"

namespace proxima {

/// Along the contact's push, m/s, in a span of ticks that ended so many ticks ago.
double BounceDetector::speed(std::size_t ago) const noexcept
{
    const Tick& end = at(ago);
    const Tick& begin = at(ago + span);
    return axis_.dot(end.position - begin.position) / (end.seconds - begin.seconds);
}

/// A contact begins.
void BounceDetector::touch(const Vec3& along) noexcept
{
    // Both speeds are as far from the contact: then so is what a push changed of them.
    counts_ = free_ticks_ >= 2 * settling + span;
    last_ = {};
    touching_ = 0;
    if (!counts_) return;
    axis_ = along;
    last_.touched = true;
    last_.flight = flight_;
    last_.speed_in = -speed(settling);
}

Bounce BounceDetector::watch(const Vec3& position, const Vec3& force, double seconds,
                             double most_force) noexcept
{
    const double time = at(0).seconds + seconds;
    ++now_;
    ticks_[now_ % kept] = {position, time};
    const double size = force.norm();
    flight_ += seconds;
    if (!(size > 0)) {
        touches_ = false;
        ++free_ticks_;
        if (!counts_ || free_ticks_ != settling + span) return {};
        Bounce over = last_;
        over.touched = false;
        over.left = true;
        over.speed_out = speed(0);
        return over;
    }
    const Vec3 along = force / size;
    constexpr double least_cosine = 0.8;
    Bounce result;
    if (!touches_) {
        touch(along);
        result = last_;
    }
    touches_ = true;
    flight_ = 0;
    free_ticks_ = 0;
    counts_ = counts_ && along.dot(axis_) >= least_cosine;
    touching_ += seconds;
    last_.contact += size < most_force ? seconds : 0;
    return result;
}

} // namespace proxima
