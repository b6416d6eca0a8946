// Passivity: a virtual wall must not give more energy than it took, or the device starts to swing
// by itself ([hannaford-2002]).
//
//     observer     E += -F . (x - x_before)      exactly what a held force took from the hand
//     controller   where the next tick would make E negative, damping
//                  alpha = -E / (T v^2) is added: the force loses alpha v
#pragma once

#include "proxima/geometry/vec.h"

#include <cstdint>

namespace proxima {

/// One per device. noexcept, no allocation, O(1).
class PassivityGuard {
public:
    /// \pre max_damping >= 0, N s/m: no more is ever added, for held damping swings by itself
    explicit PassivityGuard(double max_damping) noexcept : max_damping_(max_damping) {}

    /// The force to be held over the next tick, where the device said `position` and `velocity` and
    /// `force` is wanted. \pre all finite, seconds > 0
    [[nodiscard]] Vec3 pass(const Vec3& position, const Vec3& velocity, const Vec3& force,
                            double seconds) noexcept;

    /// What the device got instead, where guards further on changed it: accounts are by that.
    void applied(const Vec3& force) noexcept { last_force_ = force; }

    /// Opens new accounts: where nothing is touched, there is nothing to give back.
    void restart() noexcept;

    /// Taken and not given back, J. Negative: given without having taken.
    [[nodiscard]] double energy() const noexcept { return energy_; }
    [[nodiscard]] double lowest_energy() const noexcept { return lowest_; } ///< ever
    [[nodiscard]] std::uint64_t damped_ticks() const noexcept { return damped_; }

private:
    double max_damping_;
    double energy_ = 0;
    double lowest_ = 0;
    Vec3 last_position_ = Vec3::Zero();
    Vec3 last_force_ = Vec3::Zero();
    bool running_ = false;
    std::uint64_t damped_ = 0;
};

} // namespace proxima
