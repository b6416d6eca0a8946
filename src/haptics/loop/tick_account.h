// Counts and times the ticks that a driver's scheduler calls, as run_servo_loop() does for its own.
#pragma once

#include "proxima/device.h"

#include <cstdint>

namespace proxima {

/// One thread at a time; finish() once no tick runs any more.
class TickAccount {
public:
    /// Refers to the callable of `called`, which must outlive every tick. \pre the rate is positive
    TickAccount(const ServoOptions& options, ServoTick called) noexcept;

    /// Calls the next tick. Returns stop once it does or all are done. noexcept, no allocation.
    Flow tick() noexcept;

    [[nodiscard]] ServoStatistics finish() const { return seen_; }

private:
    ServoOptions options_;
    ServoTick tick_;
    ServoStatistics seen_;
    std::int64_t begin_ = 0; ///< ns
    std::int64_t last_ = 0;  ///< ns, the beginning of the last tick
};

} // namespace proxima
