// The length of a tick in tests of touch.
#pragma once

namespace proxima::testing {

inline constexpr double tick_seconds = 1e-3;

} // namespace proxima::testing
