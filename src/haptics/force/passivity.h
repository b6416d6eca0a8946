// Passivity: a virtual wall must not give more energy than it took, or the device starts to
// oscillate by itself ([hannaford-2002]).
//
//     observer     E += -F . (x - x_before)      exactly what a held force took from the hand
//     controller   where the next tick would make E negative, damping
//                  alpha = -E / (T v^2) is added: the force loses alpha v
//     softening    where the contact oscillates all the same (oscillation_detector.h), because the
//                  device allows no more damping, or forces arrive later than the observer knows:
//                  the force is scaled by s < 1, with a damping of B_max (1 - s) sqrt(s), and s
//                  recovers slowly
//
// Wall and softening together never damp more than the device allows: a wall has at most s B_max of
// its own. Each time that a contact oscillates again before s has recovered, the next recovery takes
// twice as long, for the hand that holds the device has not changed.
#pragma once

#include "haptics/force/oscillation_detector.h"
#include "proxima/geometry.h"

#include <cstdint>

namespace proxima {

/// One per device. noexcept, no allocation, O(1).
class PassivityGuard {
public:
    /// \pre max_damping >= 0, N s/m: the most that is added, for more damping oscillates by itself
    explicit PassivityGuard(double max_damping) noexcept : max_damping_(max_damping) {}

    /// The force for the next tick, of a device at `position` with `velocity` and a wanted `force`.
    /// \pre all finite, seconds > 0
    [[nodiscard]] Vec3 pass(const Vec3& position, const Vec3& velocity, const Vec3& force,
                            double seconds) noexcept;

    /// A tick without contact: resets the energy, for there is nothing to give back.
    void leave(const Vec3& position, double seconds) noexcept;

    /// Tells the observer the force that the device got after later guards.
    void applied(const Vec3& force) noexcept { last_force_ = force; }

    /// Starts anew: the device jumped, or it touches another surface.
    void restart() noexcept;

    /// Whether the last contact is so long ago that motions in it no longer matter.
    [[nodiscard]] bool is_away() const noexcept { return oscillations_.is_away(); }

    /// Energy taken from the hand and not given back, J; negative where more was given.
    [[nodiscard]] double energy() const noexcept { return energy_; }
    [[nodiscard]] double lowest_energy() const noexcept { return lowest_; } ///< so far
    [[nodiscard]] std::uint64_t damped_ticks() const noexcept { return damped_; }

    /// s, 1 where no contact has oscillated.
    [[nodiscard]] double softness() const noexcept { return softness_; }
    /// The damping that softening adds, N s/m.
    [[nodiscard]] double added_damping() const noexcept;
    [[nodiscard]] double lowest_softness() const noexcept { return softest_; } ///< so far
    [[nodiscard]] std::uint64_t softened_ticks() const noexcept { return softened_; }

private:
    void soften(double growth) noexcept;
    void recover(double seconds) noexcept;
    void reset_energy() noexcept;
    [[nodiscard]] double most_alpha() const noexcept;
    [[nodiscard]] Vec3 softened(const Vec3& force, const Vec3& velocity) const noexcept;

    double max_damping_;
    double energy_ = 0;
    double lowest_ = 0;
    Vec3 last_position_ = Vec3::Zero();
    Vec3 last_force_ = Vec3::Zero();
    bool running_ = false;
    std::uint64_t damped_ = 0;
    OscillationDetector oscillations_;
    double softness_ = 1;
    double softest_ = 1;
    double recovery_ = 0; ///< s, in which s doubles; 0 where s is 1
    std::uint64_t softened_ = 0;
};

} // namespace proxima
