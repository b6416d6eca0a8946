// What a tick costs in a scene: several objects, at rest and moving.
#pragma once

#include "touch_curve.h"

namespace proxima::bench {

/// Times ticks of a hand that follows all scripts over scenes of one to 64 objects, at rest and
/// moving, and prints a table; a replay that gives another force fails. Returns the exit status.
[[nodiscard]] int run_scenes(const TouchRaceOptions& options);

} // namespace proxima::bench
