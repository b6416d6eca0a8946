// Swings of a few ticks, which means of speeds (oscillation_detector.h) do not see: by the places at which
// the motion turns.
//
//     leg      from one turn to the next, in at most 6 ticks: no hand does that
//     swing    8 legs in succession of 0.3 mm or more, of which the last four are as long as the
//              first four
//
// Where a motion is sampled a few times in a period, the legs that are seen are now longer, now
// shorter than those that are: so four are compared with four.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>

namespace proxima {

/// One per device. noexcept, no allocation, O(1).
class FastOscillations {
public:
    /// A tick near a contact. Returns the growth log(last four / first four) of legs that prove
    /// that the contact swings by itself, at least a hundredth; else 0. \pre finite
    [[nodiscard]] double watch(const Vec3& position) noexcept;

    /// As new: nothing is touched, or the device is somewhere else.
    void restart() noexcept { *this = {}; }

private:
    [[nodiscard]] double turn() noexcept;

    static constexpr std::size_t legs = 8;

    std::array<double, legs> lengths_ = {}; ///< m, of the last ones
    std::size_t count_ = 0;                 ///< of them, in succession
    Vec3 turned_ = Vec3::Zero();            ///< where the leg began
    Vec3 farthest_ = Vec3::Zero();          ///< where it has come to
    int ticks_ = 0;                         ///< that it took
    bool placed_ = false;
};

} // namespace proxima
