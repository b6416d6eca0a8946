#include "haptics/force/energy_account.h"

#include <algorithm>
#include <limits>

namespace proxima {

double EnergySums::most_given_since(const EnergySums& earlier) const noexcept
{
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t delay = 0; delay < given.size(); ++delay)
        most = std::max(most, given[delay] - earlier.given[delay]);
    return most;
}

void EnergyAccount::add(const Vec3& position, const Vec3& spring, double seconds,
                        const Vec3& surface) noexcept
{
    ++now_;
    const Tick& before = at(1);
    Tick& tick = at(0);
    const bool first = now_ == kept + 1;
    const double returned =
        first ? 0 : 0.5 * (before.spring + spring).dot(position - before.position);
    tick = {position, position - surface, spring, Vec3::Zero(), returned};
    // The ticks before the first one are at rest where it is.
    if (first) {
        for (Tick& each : ticks_) {
            each.position = position;
            each.relative = tick.relative;
        }
    }
    returned_ += returned - at(window).returned;
    const Vec3 step = (position - at(window).position) / static_cast<double>(window);
    const double returned_in_step = returned_ / static_cast<double>(window);
    bool in_contact = false;
    for (std::size_t delay = 0; delay <= most_delay_ticks; ++delay) {
        // Of the two ticks in the middle of the window.
        const std::size_t ago = window / 2 + delay;
        const Vec3 force = 0.5 * (at(ago).force + at(ago + 1).force);
        sums_.given[delay] += force.dot(step) - returned_in_step;
        in_contact = in_contact || force != Vec3::Zero();
    }
    const double motion = step.squaredNorm() / seconds;
    sums_.motion += motion;
    sums_.motion_in_contact += in_contact ? motion : 0;
    const Vec3 relative = (tick.relative - at(window).relative) / static_cast<double>(window);
    sums_.relative_motion += relative.squaredNorm() / seconds;
}

} // namespace proxima
