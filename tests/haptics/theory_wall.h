// A wall as theory has it, which fills all space, and from which stiffness on a device that nobody
// holds swings in it.
#pragma once

#include "lab/simulated_hand.h"
#include "proxima/device.h"

#include <algorithm>
#include <cmath>

namespace proxima::testing {

struct TheoryWall {
    double stiffness = 0; ///< N/m
    double damping = 0;   ///< N s/m

    [[nodiscard]] Vec3 force(const DeviceState& state) const
    {
        return -stiffness * state.pose.translation - damping * state.velocity;
    }
};

inline HandModel without_hand()
{
    HandModel model;
    model.hand_stiffness = 0;
    model.hand_damping = 0;
    return model;
}

/// The largest |x| in the last tenth of some ticks, m, let go a millimetre away; 1 where it left.
inline double theory_swing(const HandModel& model, const TheoryWall& wall, int ticks)
{
    SimulatedHand hand(model, Vec3(1e-3, 0, 0));
    double largest = 0;
    for (int tick = 0; tick < ticks; ++tick) {
        hand.step(wall.force(hand.state()), Vec3::Zero());
        const double x = std::abs(hand.position().x());
        if (!(x < 1)) return 1;
        if (tick >= ticks - ticks / 10) largest = std::max(largest, x);
    }
    return largest;
}

/// The stiffness at which a swing neither grows nor fades, N/m, by halving.
inline double stiffness_limit(const HandModel& model, double damping)
{
    double stable = 1;
    double unstable = 1e5;
    while (unstable / stable > 1.0005) {
        const double middle = std::sqrt(stable * unstable);
        const bool fades = theory_swing(model, {middle, damping}, 40000) < 1e-3;
        (fades ? stable : unstable) = middle;
    }
    return stable;
}

} // namespace proxima::testing
