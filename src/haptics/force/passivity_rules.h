// The numbers by which contacts that give energy are judged and answered, of points (passivity.h) and
// of tools (tool/tool_passivity.h).
#pragma once

#include "haptics/force/energy_account.h"

#include <cmath>
#include <numbers>

namespace proxima::passivity_rule {

/// N s/m: the friction of the best devices. Less than this is not enough to keep a swing going, and
/// less damping ends none.
inline constexpr double least_device_damping = 0.1;

/// Damping and softening answer two legs in succession that do not fade. A leg that is half as long
/// again as the one before counts twice.
inline constexpr int least_legs = 2;

/// The damping of an answer, in parts of what leaves a contact that gives nothing: it takes as much
/// as it gave, so what grew by itself fades as fast.
inline constexpr double firmness = 2;

/// A leg is compared with the shorter of the two before it. So the third leg after an answer is the
/// first one that is compared with legs after the answer alone.
inline constexpr int hand_legs = 3;

inline constexpr double nearly_all = 0.9; ///< of the damping that is allowed
inline constexpr double least_softness = 0.2;
inline constexpr double softening = 0.7;
inline constexpr double recovery = 4; ///< s, in which s doubles, or damping halves; and of trust

/// A mass m that hits a wall is in contact for pi sqrt(m / K) or longer. With all damping that the known
/// devices allow, the wall throws it back faster than it came only if that is less than five and a
/// half times the delay of the damping: the ticks of the force's delay, half a tick for the hold, and
/// half a tick for a velocity by differences. Ticks in which a slew limit holds the force back add to
/// them.
inline constexpr double brief_contact = 6; ///< of these delays
inline constexpr double least_mass = 0.06; ///< kg: an assumption, of a device and what holds it

/// Whether a fully damped wall, whose forces are late by further ticks, may have caused a cycle with so
/// much time in contact.
[[nodiscard]] inline bool is_brief(double contact, double stiffness, int late_ticks,
                                   double tick_seconds) noexcept
{
    const double longest = brief_contact * (most_delay_ticks + 1 + late_ticks) * tick_seconds;
    const double least = std::numbers::pi * std::sqrt(least_mass / stiffness);
    return contact <= longest && least <= longest;
}

} // namespace proxima::passivity_rule
