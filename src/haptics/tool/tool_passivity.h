// Keeps a tool from being given more energy than it took, as PassivityGuard (passivity.h) keeps a
// point, by the same rules (swing_response.h) in six dimensions.
//
//     state     displacement of the device's tip, and its turn times turning_lever, m
//     pull      force, and torque over that lever, N
//     energy    force times travel plus torque times turn: one account for all six
//     swings    along each axis: a tool in a hole can go round, and the force with it
//     answers   the same damping and softening for all six
//
// Where a tool touches, its axes exchange energy, and what one of them gains says little. So a hand is
// trusted only where the axis that moves most does not fade though the contact takes energy. The
// tool's own damping acts along its stretch. It gives way to the guard's, which acts along all axes.
#pragma once

#include "haptics/force/energy_account.h"
#include "haptics/force/swing_response.h"
#include "haptics/tool/least_constraint.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"

#include <array>

namespace proxima {

/// m: the radius of gyration of a rod of 108 mm, held in its middle, such as the handle of a device is.
/// There a turning handle weighs as much as a moving one. A power of two: it changes no bit of a torque.
inline constexpr double turning_lever = 1.0 / 32;

/// Limits and springs of a tool. Those of turns at the lever, as if of a force: N, N/m, N s/m.
struct ToolPullLimits {
    double max_force = 0;
    double max_turning_force = 0; ///< 0 = a device without torques
    double max_damping = 0;       ///< of either, springs and guard together
    double stiffness = 0;
    double turning_stiffness = 0;
    double damping = 0; ///< of the springs
    double turning_damping = 0;
};

/// What a tool touches.
struct TouchedGround {
    Vec6 moved = Vec6::Zero();    ///< so far, in the frame in which the tool's positions are
    Vec6 velocity = Vec6::Zero(); ///< per second, in space; zero away from contacts
};

/// One per device. noexcept, no allocation, O(1).
class ToolPassivity {
public:
    ToolPassivity(Guard mode, const ToolPullLimits& limits) noexcept : mode_(mode), limits_(limits)
    {}

    /// The pull for the next tick, from that of the springs and that with their damping; both zero
    /// away from contacts. \pre all finite, seconds > 0
    [[nodiscard]] Vec6 pass(const Vec6& position, const Vec6& velocity, const TouchedGround& ground,
                            const Vec6& spring, const Vec6& whole, double seconds) noexcept;

    /// The pull that the device got after later guards.
    void applied(const Vec6& pull) noexcept;

    /// Forgets the motion; what the guard adds stays.
    void restart() noexcept;

    /// As new.
    void reset() noexcept;

    /// Like PassivityGuard::softness().
    [[nodiscard]] double softness() const noexcept
    {
        return mode_ == Guard::on ? response_.softness() : 1;
    }
    /// Like PassivityGuard::added_damping(), of a force or at the lever.
    [[nodiscard]] double added_damping() const noexcept
    {
        return mode_ == Guard::on ? response_.damping() : 0;
    }
    [[nodiscard]] const SwingReport& report() const noexcept { return response_.report(); }

private:
    [[nodiscard]] EnergySums sums() const noexcept;
    [[nodiscard]] Vec6 clamped(Vec6 pull) const noexcept;
    [[nodiscard]] Vec6 guarded(const Vec6& spring, const Vec6& whole,
                               const Vec6& velocity) const noexcept;

    Guard mode_;
    ToolPullLimits limits_;
    std::array<WatchedMotion, 6> motions_; ///< along each axis
    EnergyAccount linear_;
    EnergyAccount angular_;
    SwingResponse response_;
    Vec6 wanted_ = Vec6::Zero(); ///< what the device would get without slew limits
};

} // namespace proxima
