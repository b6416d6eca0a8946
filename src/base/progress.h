// Progress and cancellation of long work, shared between the worker and whoever watches it.
//
//     Progress progress;
//     std::thread watcher([&] { show(progress.stage(), progress.fraction()); });
//     auto octree = build_octree(mesh, {.max_depth = 9, .progress = &progress});
//     // from a signal handler or another thread: progress.cancel();
#pragma once

#include <atomic>
#include <cstdint>

namespace proxima {

/// Lock-free: every member may be called from any thread, cancel() also from a signal handler.
class Progress {
public:
    /// The worker enters a stage of `steps` steps. `name` must outlive this object (a literal).
    void begin_stage(const char* name, std::uint64_t steps) noexcept
    {
        done_.store(0, std::memory_order_relaxed);
        steps_.store(steps, std::memory_order_relaxed);
        stage_.store(name, std::memory_order_release);
        count_report();
    }

    /// The worker finished `steps` more steps of the stage.
    void advance(std::uint64_t steps) noexcept
    {
        done_.fetch_add(steps, std::memory_order_relaxed);
        count_report();
    }

    /// Asks the worker to stop; it returns ErrorCode::cancelled soon after.
    void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }

    /// Cancels by itself at the worker's `reports`-th call of begin_stage or advance from now on: a
    /// moment that tests can choose and repeat. \pre reports > 0, no work is going on
    void cancel_after(std::uint64_t reports) noexcept
    {
        reports_left_.store(reports, std::memory_order_relaxed);
    }

    [[nodiscard]] bool cancelled() const noexcept
    {
        return cancelled_.load(std::memory_order_relaxed);
    }

    /// Name of the stage in work, "" before the first.
    [[nodiscard]] const char* stage() const noexcept
    {
        return stage_.load(std::memory_order_acquire);
    }

    /// Part of the stage that is done, 0 to 1.
    [[nodiscard]] double fraction() const noexcept
    {
        const auto steps = steps_.load(std::memory_order_relaxed);
        const auto done = done_.load(std::memory_order_relaxed);
        if (steps == 0) return 0.0;
        return done >= steps ? 1.0 : static_cast<double>(done) / static_cast<double>(steps);
    }

private:
    void count_report() noexcept
    {
        if (reports_left_.load(std::memory_order_relaxed) == 0) return;
        if (reports_left_.fetch_sub(1, std::memory_order_relaxed) == 1) cancel();
    }

    std::atomic<const char*> stage_{""};
    std::atomic<std::uint64_t> done_{0};
    std::atomic<std::uint64_t> steps_{0};
    std::atomic<std::uint64_t> reports_left_{0}; ///< until it cancels by itself; 0 = never
    std::atomic<bool> cancelled_{false};
};

/// True where a progress object is given and asks to stop.
[[nodiscard]] inline bool is_cancelled(const Progress* progress) noexcept
{
    return progress != nullptr && progress->cancelled();
}

/// One thread's small steps of a stage, handed on in blocks: one comparison per step.
///
///     StageSteps steps(progress, "collecting leaves", leaves.size());
///     for (...) if (!steps.done(1)) return cancelled;
class StageSteps {
public:
    /// Enters the stage. Progress may be null. A block should take well below 100 ms.
    StageSteps(Progress* progress, const char* name, std::uint64_t steps,
               std::uint64_t block = 4096) noexcept
        : progress_(progress), block_(block)
    {
        if (progress_ != nullptr) progress_->begin_stage(name, steps);
    }

    /// A part of a stage that somebody has entered before.
    StageSteps(Progress* progress, std::uint64_t block) noexcept
        : progress_(progress), block_(block)
    {}

    /// False where the work shall stop.
    [[nodiscard]] bool done(std::uint64_t steps) noexcept
    {
        waiting_ += steps;
        return waiting_ < block_ || report();
    }

private:
    [[nodiscard]] bool report() noexcept
    {
        if (progress_ != nullptr) progress_->advance(waiting_);
        waiting_ = 0;
        return !is_cancelled(progress_);
    }

    Progress* progress_;
    std::uint64_t block_;
    std::uint64_t waiting_ = 0;
};

} // namespace proxima
