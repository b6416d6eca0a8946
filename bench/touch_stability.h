// At which stiffness walls begin to swing, beside theory, and how far the passivity guard lets
// them.
#pragma once

namespace proxima::bench {

/// A simulated device of 0.1 kg that nobody holds, against a wall on both sides. Prints for each
/// damping and delay the stiffness at which swings neither grow nor fade, measured and by theory,
/// (b + B) / (T / 2 + delay), and for each device at its greatest stiffness how far it swings after
/// 20 s, with and without the guard. Fails where a measured limit is 2 % off, or a guarded device
/// swings by more than a millimetre.
[[nodiscard]] int run_stability_table();

} // namespace proxima::bench
