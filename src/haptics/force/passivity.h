// Passivity: a virtual wall must not give more energy than it took, or the device starts to swing
// by itself ([hannaford-2002]).
//
//     observer     E += -F . (x - x_before)      exactly what a held force took from the hand
//     controller   where the next tick would make E negative, damping
//                  alpha = -E / (T v^2) is added: the force loses alpha v
//     softening    where the contact swings all the same (oscillation_detector.h), because the device bears
//                  no more damping, or forces come later than the observer knows: the force is
//                  scaled by s < 1, with B_max (1 - s) sqrt(s) of damping, and s comes back slowly
//
// Damping by softening, of wall and guard together, is never more than the device's: a wall has at
// most s B_max of its own. Each time that a contact swings again before s is back, s takes twice
// as long, for what holds the device has not changed.
#pragma once

#include "haptics/force/oscillation_detector.h"
#include "proxima/geometry.h"

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

    /// A tick in which nothing is touched: opens new accounts, for there is nothing to give back.
    void leave(const Vec3& position, double seconds) noexcept;

    /// What the device got instead, where guards further on changed it: accounts are by that.
    void applied(const Vec3& force) noexcept { last_force_ = force; }

    /// Opens new accounts: the device or what it touches is another, and its motion begins anew.
    void restart() noexcept;

    /// Whether the last contact is so long ago that motions in it no longer matter.
    [[nodiscard]] bool is_away() const noexcept { return swings_.is_away(); }

    /// Taken and not given back, J. Negative: given without having taken.
    [[nodiscard]] double energy() const noexcept { return energy_; }
    [[nodiscard]] double lowest_energy() const noexcept { return lowest_; } ///< ever
    [[nodiscard]] std::uint64_t damped_ticks() const noexcept { return damped_; }

    /// s, 1 where no contact has swung by itself.
    [[nodiscard]] double softness() const noexcept { return softness_; }
    /// N s/m, that softening adds.
    [[nodiscard]] double added_damping() const noexcept;
    [[nodiscard]] double lowest_softness() const noexcept { return softest_; } ///< ever
    [[nodiscard]] std::uint64_t softened_ticks() const noexcept { return softened_; }

private:
    void soften(double growth) noexcept;
    void recover(double seconds) noexcept;
    void open_accounts() noexcept;
    [[nodiscard]] double most_alpha() const noexcept;
    [[nodiscard]] Vec3 softened(const Vec3& force, const Vec3& velocity) const noexcept;

    double max_damping_;
    double energy_ = 0;
    double lowest_ = 0;
    Vec3 last_position_ = Vec3::Zero();
    Vec3 last_force_ = Vec3::Zero();
    bool running_ = false;
    std::uint64_t damped_ = 0;
    OscillationDetector swings_;
    double softness_ = 1;
    double softest_ = 1;
    double recovery_ = 0; ///< s, in which s doubles; 0 where there is nothing to come back from
    std::uint64_t softened_ = 0;
};

} // namespace proxima
