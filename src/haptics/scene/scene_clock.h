// The time of a scene: that of the tool which is ahead.
//
//     scene    ───────────────●      raised by every tick
//     tool 0   ──────────────●       its own ticks added up
//     tool 1   ─────────●···>        behind by more than three ticks: moved on
//
// Servo loops lose ticks and have clocks of their own, so the sums of their ticks drift apart. A loop
// that is behind by more than a burst of ticks makes up for, lost them.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>

namespace proxima {

/// Nanoseconds since the scene was made. Whole numbers, so that all views compute the same bits.
using SceneTime = std::int64_t;

[[nodiscard]] inline double seconds_between(SceneTime from, SceneTime to) noexcept
{
    return static_cast<double>(to - from) / 1e9;
}

/// Any thread; lock-free.
class SceneClock {
public:
    [[nodiscard]] SceneTime now() const noexcept { return now_.load(std::memory_order_relaxed); }

    /// Moves the clock on to a time, unless it is past it.
    void raise(SceneTime time) noexcept
    {
        SceneTime now = now_.load(std::memory_order_relaxed);
        while (now < time && !now_.compare_exchange_weak(now, time, std::memory_order_relaxed)) {
        }
    }

private:
    static_assert(std::atomic<SceneTime>::is_always_lock_free);
    alignas(64) std::atomic<SceneTime> now_{0};
};

/// The time of one tool. One thread.
class ToolClock {
public:
    /// Most ticks by which a tool lags behind the scene, and most seconds where these are more.
    static constexpr SceneTime most_ticks_behind = 3;
    static constexpr SceneTime most_behind = 3'000'000;

    [[nodiscard]] SceneTime now() const noexcept { return now_; }

    /// Begins anew at the scene's time, with which the first tick will end at the earliest.
    void start(const SceneClock& scene) noexcept
    {
        now_ = scene.now();
        started_ = false;
    }

    /// Adds a tick. Returns the seconds that passed: the tick's, or more where the tool was too far
    /// behind. \pre seconds > 0
    double advance(SceneClock& scene, double seconds) noexcept
    {
        constexpr double longest_tick = 1e6; // no sum of ticks overflows before
        const auto tick =
            static_cast<SceneTime>(std::llround(std::min(seconds, longest_tick) * 1e9));
        const SceneTime allowed = started_ ? std::max(most_behind, most_ticks_behind * tick) : 0;
        started_ = true;
        const SceneTime before = now_;
        now_ += tick;
        scene.raise(now_);
        const SceneTime behind = scene.now() - now_ - allowed;
        if (behind <= 0) return seconds;
        now_ += behind;
        return seconds_between(before, now_);
    }

private:
    SceneTime now_ = 0;
    bool started_ = false;
};

} // namespace proxima
