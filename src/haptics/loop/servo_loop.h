// A loop that keeps its rate: sleeps to absolute times, counts what it missed.
//
//     const ServoStatistics seen = run_servo_loop({.rate = 1000, .ticks = 5000}, [&](auto tick) {
//         device.step(renderer.tick(device.state(), 1e-3).force, ...);
//         return Flow::proceed;
//     });
//
// Tick i is planned at begin + i / rate. One that ends after the next was planned has missed its
// deadline; planned times that passed meanwhile are left out, not caught up with.
#pragma once

#include "haptics/loop/latency_histogram.h"
#include "proxima/octree.h"

#include <cstdint>
#include <string>
#include <type_traits>

namespace proxima {

enum class Pace : std::uint8_t {
    real_time,   ///< at its rate, with real-time priority and locked memory where these are granted
    best_effort, ///< at its rate, as any other thread
    unpaced      ///< tick after tick: for tests and measurements
};

struct ServoOptions {
    double rate = 1000; ///< ticks per second
    std::uint64_t ticks = 1000;
    Pace pace = Pace::best_effort;
};

struct ServoStatistics {
    std::uint64_t ticks = 0;
    std::uint64_t missed = 0;      ///< deadlines
    std::uint64_t overslept = 0;   ///< of these: woken up after the deadline, before any work
    std::uint64_t skipped = 0;     ///< planned times that were left out
    double seconds = 0;            ///< from the first tick to the last
    LatencyHistogram late;         ///< waking up after the planned time, ns
    LatencyHistogram work;         ///< inside of ticks, ns
    std::uint64_t page_faults = 0; ///< of this thread, from the first tick to the last
    bool real_time_priority = false;
    bool locked_memory = false;
    std::string note; ///< what was asked for and not granted, and what would help; empty if nothing
};

namespace detail {
using ServoTick = Flow (*)(void* context, std::uint64_t tick) noexcept;
[[nodiscard]] ServoStatistics run_servo_loop(const ServoOptions& options, ServoTick tick,
                                             void* context);

/// Ticks that somebody else's clock calls: counted and timed as those of our loop. One thread at a
/// time; finish() once no tick runs any more.
class TickAccount {
public:
    TickAccount(const ServoOptions& options, ServoTick called, void* context) noexcept;

    /// The next tick; stop once it says so or all are done. noexcept, without allocation.
    Flow tick() noexcept;

    [[nodiscard]] ServoStatistics finish() const { return seen_; }

private:
    ServoOptions options_;
    ServoTick tick_;
    void* context_;
    ServoStatistics seen_;
    std::int64_t begin_ = 0; ///< ns
    std::int64_t last_ = 0;  ///< the last tick's beginning
};

/// Any callable as a plain function of its address.
template <class Callable>
Flow plain_tick(void* context, std::uint64_t number) noexcept
{
    return (*static_cast<Callable*>(context))(number);
}
} // namespace detail

/// Calls tick(number) for every tick on this thread, until it says stop or all are done. Between
/// the first and the last tick nothing is allocated. The tick must not throw.
/// \pre rate is positive and finite
template <class Tick>
[[nodiscard]] ServoStatistics run_servo_loop(const ServoOptions& options, Tick&& tick)
{
    return detail::run_servo_loop(options, detail::plain_tick<std::remove_reference_t<Tick>>,
                                  const_cast<void*>(static_cast<const void*>(&tick)));
}

} // namespace proxima
