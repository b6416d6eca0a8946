// Hours of hands that tap, tremble, press and write: no force may be lost.
#pragma once

#include <cstdint>
#include <string>

namespace proxima::soak {

/// Runs the sessions of tests/haptics/hand_sessions.h whose names contain `name`, for every known
/// device or one of them, at the default stiffness and, with `hardest`, at the device's greatest, for
/// so many seconds each. Prints a row for each device and stiffness and a line for each session that
/// lost force; exit status 1 if any did at the default stiffness.
///
///     damped    part of the ticks in which the guard added damping, of all sessions and most of one
///     taken     most of one session: mean change of the force by the guards over the mean force
///     softened  sessions in which it softened the force, and the least factor
///     faulty    sessions whose input was not trusted
[[nodiscard]] int run_hand_soak(double seconds, std::uint64_t seed, bool hardest,
                                const std::string& device, const std::string& name);

} // namespace proxima::soak
