// The time of a scene: that of the tool which is ahead.
//
//     scene    ──────────────●       the latest of these
//     tool 0   ──────────────●       its own ticks added up
//     tool 1   ─────────●···>        behind by more than three ticks: moved on
//
// Servo loops lose ticks and have clocks of their own, so the sums of their ticks drift apart. A loop
// that is behind by more ticks than it can make up for in a burst has lost them.
#pragma once

#include "proxima/touch_scene.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace proxima {

/// Nanoseconds since the scene was made. Whole numbers, so that all views compute the same bits.
using SceneTime = std::int64_t;

[[nodiscard]] inline double seconds_between(SceneTime from, SceneTime to) noexcept
{
    return static_cast<double>(to - from) / 1e9;
}

/// The times of all tools. Any thread; wait-free.
class SceneClock {
public:
    [[nodiscard]] SceneTime now() const noexcept
    {
        SceneTime latest = 0;
        for (const auto& time : times_)
            latest = std::max(latest, time.load(std::memory_order_relaxed));
        return latest;
    }

    /// A tool's time, which never falls; that of a tool that ended stays.
    void set(std::size_t tool, SceneTime time) noexcept
    {
        times_[tool].store(time, std::memory_order_relaxed);
    }

private:
    static_assert(std::atomic<SceneTime>::is_always_lock_free);
    alignas(64) std::array<std::atomic<SceneTime>, max_scene_tools> times_{};
};

/// The time of one tool. One thread.
class ToolClock {
public:
    explicit ToolClock(std::size_t tool) noexcept : tool_(tool) {}

    /// A tool lags behind the scene by at most so many of its ticks, or so many ns where these are more.
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
        constexpr double longest_tick = 1e6;
        constexpr SceneTime end = std::numeric_limits<SceneTime>::max() / 2; // 146 years
        const SceneTime tick =
            std::min<SceneTime>(std::llround(std::min(seconds, longest_tick) * 1e9), end - now_);
        const SceneTime allowed = started_ ? std::max(most_behind, most_ticks_behind * tick) : 0;
        started_ = true;
        const SceneTime before = now_;
        now_ += tick;
        scene.set(tool_, now_);
        const SceneTime behind = scene.now() - now_ - allowed;
        if (behind <= 0) return seconds;
        now_ += behind;
        return seconds_between(before, now_);
    }

private:
    std::size_t tool_;
    SceneTime now_ = 0;
    bool started_ = false;
};

} // namespace proxima
