// What a surface costs that changes its shape while it is touched: frames and ticks.
#pragma once

#include "touch_curve.h"

namespace proxima::bench {

/// Times refits and ticks of a cloth of 20,000 triangles over which a wave runs at 60 frames a
/// second, with a hand that rests on it, strokes and pokes it, and prints a table; a replay that gives
/// another force fails. Returns the exit status.
[[nodiscard]] int run_changes(const TouchRaceOptions& options);

} // namespace proxima::bench
