// Which velocities the positions of a device confirm: a device that reports speed must have moved.
//
//     u_i  = (x_i - x_i-1) / (t_i - t_i-1)         of the last samples
//     plausible   within [min u_i - margin, max u_i + margin] along each axis
//     margin    = max |u_i - u_i-1|                 acceleration
//               + 3 step / (t_i - t_i-1)            encoders have steps
//               + 5 mm/s
//
// So correct velocities are plausible: exact ones, filtered ones, which are delayed, and those of a
// coarse encoder, whose differences are zero or whole steps. The reason: u_i is the mean velocity
// of a tick, up to one step. The velocity at the end of the tick differs from that mean by half a
// tick of acceleration. Where the acceleration began with the tick, u_i differs by as much from
// u_i-1, up to two steps. The step is learned: the least displacement along an axis that any sample
// had. Before the first sample the device is taken to be at rest.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>

namespace proxima {

/// One per device. noexcept, no allocation, O(1).
class VelocityBounds {
public:
    /// A new position, m, so many seconds after the last one. \pre finite, seconds > 0
    void add(const Vec3& position, double seconds) noexcept;

    /// The velocity that a device reported where it is plausible, m/s; else the last difference of
    /// positions, and zero where there is none or the velocity is not finite.
    [[nodiscard]] Vec3 plausible(const Vec3& reported) const noexcept;

    /// Starts anew: the next position is unrelated to the last.
    void restart() noexcept { *this = {}; }

private:
    static constexpr std::size_t samples = 8;

    std::array<Vec3, samples> velocities_ = {};
    std::size_t count_ = 0; ///< of all velocities so far
    double step_ = 0;       ///< m, of the encoder; 0 while nothing has moved
    double seconds_ = 1;    ///< of the last sample
    Vec3 last_position_ = Vec3::Zero();
    bool placed_ = false;
};

} // namespace proxima
