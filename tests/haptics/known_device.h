// Simulated devices whose numbers are known, and how near a fit of their motion comes to them.
#pragma once

#include "haptics/device/motion_fit.h"
#include "lab/simulated_hand.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace proxima::testing {

inline HandModel device(double mass, double damping, double friction, double step, int delay)
{
    HandModel model;
    model.mass = mass;
    model.device_damping = damping;
    model.coulomb_friction = friction;
    model.encoder_step = step;
    model.delay_ticks = delay;
    return model;
}

/// Mass to 3 %; friction to 3 % or 0.005 N, damping to 5 % or 0.05 N s/m, and both to four standard
/// errors where these are more; the delay exactly.
inline void expect_numbers(const MotionFit& fit, const HandModel& model)
{
    ASSERT_TRUE(fit.found);
    EXPECT_EQ(fit.delay, model.delay_ticks);
    EXPECT_LE(fit.least_delay, model.delay_ticks);
    EXPECT_GE(fit.most_delay, model.delay_ticks);
    EXPECT_NEAR(fit.mass.value, model.mass, 0.03 * model.mass);
    EXPECT_NEAR(fit.friction.value, model.coulomb_friction,
                std::max({0.03 * model.coulomb_friction, 0.005, 4 * fit.friction.error}));
    EXPECT_NEAR(fit.damping.value, model.device_damping,
                std::max({0.05 * model.device_damping, 0.05, 4 * fit.damping.error}));
}

} // namespace proxima::testing
