// Which velocities the places of a device bear out: what says it is fast must have moved.
//
//     u_i  = (x_i - x_i-1) / (t_i - t_i-1)         of the last samples
//     said   within [min u_i - room, max u_i + room] along each axis
//     room = max |u_i - u_i-1|                     it speeds up
//          + 3 step / (t_i - t_i-1)                encoders have steps
//          + 5 mm/s
//
// So an honest velocity is believed: an exact one, also one that is filtered, and so comes late,
// and one of a coarse encoder, whose differences are zero or whole steps. For u_i is the mean of a
// tick but for a step, the velocity at its end is farther from that mean by half a tick of speeding
// up, and so much, where it began with the tick, u_i is from u_i-1, but for two steps. The step is
// learned: the least way along an axis that the device ever moved in a sample. Before the first
// sample it is taken to be at rest.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>

namespace proxima {

/// One per device. noexcept, no allocation, O(1).
class VelocityBounds {
public:
    /// A new place, m, so many seconds after the last one. \pre finite, seconds > 0
    void add(const Vec3& place, double seconds) noexcept;

    /// The velocity as said where places bear it out, m/s; else the last difference,
    /// rest before there are any, and for what is no number. Any numbers.
    [[nodiscard]] Vec3 believed(const Vec3& said) const noexcept;

    /// As new: the next place has nothing to do with the last.
    void restart() noexcept { *this = {}; }

private:
    static constexpr std::size_t samples = 8;

    std::array<Vec3, samples> velocities_ = {};
    std::size_t count_ = 0; ///< of velocities, all
    double step_ = 0;       ///< m, of the encoder; 0 while nothing has moved
    double seconds_ = 1;    ///< of the last sample
    Vec3 last_place_ = Vec3::Zero();
    bool placed_ = false;
};

} // namespace proxima
