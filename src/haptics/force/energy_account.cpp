#include "haptics/force/energy_account.h"

#include <algorithm>
#include <limits>

namespace proxima {

double MotionSums::most_given_since(const MotionSums& earlier) const noexcept
{
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t delay = 0; delay < given.size(); ++delay)
        most = std::max(most, given[delay] - earlier.given[delay]);
    return most;
}

MotionSums& MotionSums::operator+=(const MotionSums& other) noexcept
{
    for (std::size_t delay = 0; delay < given.size(); ++delay) given[delay] += other.given[delay];
    motion += other.motion;
    motion_in_contact += other.motion_in_contact;
    return *this;
}

/// The step to the last tick's place, spread over the window.
void EnergyAccount::add_step(Place Tick::*place, double& returned, MotionSums& sums,
                             double seconds) noexcept
{
    const Place& there = at(0).*place;
    const Place& left = at(window).*place;
    returned += there.returned - left.returned;
    const Vec3 step = (there.position - left.position) / static_cast<double>(window);
    const double returned_in_step = returned / static_cast<double>(window);
    bool in_contact = false;
    for (std::size_t delay = 0; delay <= most_delay_ticks; ++delay) {
        // The mean force of the two ticks in the middle of the window.
        const std::size_t ago = window / 2 + delay;
        const Vec3 force = 0.5 * (at(ago).force + at(ago + 1).force);
        sums.given[delay] += force.dot(step) - returned_in_step;
        in_contact = in_contact || force != Vec3::Zero();
    }
    const double motion = step.squaredNorm() / seconds;
    sums.motion += motion;
    sums.motion_in_contact += in_contact ? motion : 0;
}

void EnergyAccount::add(const Vec3& position, const Vec3& spring, double seconds,
                        const Vec3& surface) noexcept
{
    ++now_;
    const Tick& before = at(1);
    Tick& tick = at(0);
    const bool first = now_ == kept + 1;
    const Vec3 relative = position - surface;
    const Vec3 mean = first ? Vec3(Vec3::Zero()) : Vec3(0.5 * (before.spring + spring));
    tick = {{position, mean.dot(position - before.own.position)},
            {relative, mean.dot(relative - before.relative.position)},
            spring,
            Vec3::Zero()};
    // The ticks before the first one are at rest where it is.
    if (first) {
        for (Tick& each : ticks_) {
            each.own.position = position;
            each.relative.position = relative;
        }
    }
    add_step(&Tick::own, returned_, sums_.own, seconds);
    add_step(&Tick::relative, relative_returned_, sums_.relative, seconds);
}

} // namespace proxima
