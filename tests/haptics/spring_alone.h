// The spring of a contact and nothing else: neither ramps nor damping, friction or guard.
#pragma once

#include "proxima/haptic_renderer.h"

namespace proxima::testing {

inline RenderOptions spring_alone(double stiffness)
{
    return {.force = {.stiffness = stiffness,
                      .damping = 0,
                      .max_slew = 1e9,
                      .start_seconds = 0,
                      .loss_seconds = 0},
            .static_friction = 0,
            .dynamic_friction = 0,
            .guard = Guard::off};
}

} // namespace proxima::testing
