// Detects oscillations of a few ticks, which mean speeds (oscillation_detector.h) do not show, by the
// positions at which the motion turns.
//
//     leg            from one turn to the next, in at most 6 ticks: faster than any hand
//     oscillation    8 legs in succession of 0.3 mm or more, of which the last four are as long as
//                    the first four
//
// With few samples in a period, single sampled legs are longer or shorter than the true ones, so
// four are compared with four.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>

namespace proxima {

/// One per device. noexcept, no allocation, O(1).
class FastOscillations {
public:
    /// A tick near a contact. Returns the growth log(last four / first four) of legs that prove an
    /// oscillation of the contact, at least a hundredth; else 0. \pre finite
    [[nodiscard]] double watch(const Vec3& position) noexcept;

    /// Starts anew: nothing is touched, or the device jumped.
    void restart() noexcept { *this = {}; }

private:
    [[nodiscard]] double turn() noexcept;

    static constexpr std::size_t legs = 8;

    std::array<double, legs> lengths_ = {}; ///< m, of the last legs
    std::size_t count_ = 0;                 ///< of legs in succession
    Vec3 turned_ = Vec3::Zero();            ///< start of the leg
    Vec3 farthest_ = Vec3::Zero();          ///< its end so far
    int ticks_ = 0;                         ///< its duration
    bool placed_ = false;
};

} // namespace proxima
