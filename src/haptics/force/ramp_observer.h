// Keeps a force that ramps up from giving energy ([hannaford-2002]). A spring that becomes stiffer while
// it is pressed gives back more than it took.
//
//     observer     E -= F . (x - x_before)      what the contact took from the hand
//     controller   where the next tick would make E negative, damping alpha = -E / (T v^2)
#pragma once

#include "proxima/geometry.h"

namespace proxima {

/// One per device. noexcept, no allocation, O(1).
class RampObserver {
public:
    /// \pre max_damping >= 0, N s/m: the most that is added
    explicit RampObserver(double max_damping) noexcept : max_damping_(max_damping) {}

    /// The force for the next tick of a contact. \pre all finite, seconds > 0
    [[nodiscard]] Vec3 pass(const Vec3& position, const Vec3& velocity, const Vec3& force,
                            double seconds) noexcept;

    /// The force that the device got after later guards.
    void applied(const Vec3& force) noexcept { applied_ = force; }

    /// Begins a new account: nothing is touched, or the ramp is over.
    void restart() noexcept
    {
        energy_ = 0;
        running_ = false;
    }

private:
    double max_damping_;
    double energy_ = 0; ///< J
    Vec3 position_ = Vec3::Zero();
    Vec3 applied_ = Vec3::Zero(); ///< N, in the last tick
    bool running_ = false;
};

} // namespace proxima
