// How an operation runs: on how many threads, watched and cancelled by whom, in how much memory.
//
//     Progress progress;
//     std::thread watcher([&] { show(progress.stage(), progress.fraction()); });
//     auto octree = build_octree(mesh, {.max_depth = 9, .execution = {.progress = &progress}});
//     // from a signal handler or another thread: progress.cancel();
//
// Options of operations that run long or on several threads end with an Execution. Results have the same bits for every
// number of threads. The budget refuses work, bounds how narrow deviations become, and which lists with_lists() keeps.
#pragma once

#include "proxima/export.h"

#include <atomic>
#include <cstdint>

namespace PROXIMA_EXPORT proxima {

/// How many threads an operation may use, 1024 at most. 0 = all that the machine offers.
struct Threads {
    int count = 0;
};

/// How much memory an operation may use for its result and its scratch, in bytes.
/// 0 = three quarters of the machine's memory, or of the container's limit, or of `ulimit -v`.
struct MemoryBudget {
    std::uint64_t bytes = 0;
};

/// Progress and cancellation of long work, shared between the worker and whoever watches it.
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

    /// Cancels at the worker's `reports`-th call of begin_stage or advance from now on: a moment
    /// that tests can choose and repeat. \pre reports > 0, no work is going on
    void cancel_after(std::uint64_t reports) noexcept
    {
        reports_left_.store(reports, std::memory_order_relaxed);
    }

    /// Whether the worker has been asked to stop.
    [[nodiscard]] bool cancelled() const noexcept
    {
        return cancelled_.load(std::memory_order_relaxed);
    }

    /// Name of the current stage, "" before the first.
    [[nodiscard]] const char* stage() const noexcept
    {
        return stage_.load(std::memory_order_acquire);
    }

    /// The part of the stage that is done, 0 to 1.
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
    std::atomic<std::uint64_t> reports_left_{0}; ///< reports before it cancels itself; 0 = never
    std::atomic<bool> cancelled_{false};
};

/// How an operation runs. An operation ignores what does not apply to it: the number of threads
/// where it works on one, the budget where its memory is small or linear in its input.
struct Execution {
    Threads threads = {};         ///< all by default
    Progress* progress = nullptr; ///< where given, receives reports and can cancel the work
    MemoryBudget budget = {};     ///< of the result and scratch, without the inputs
};

/// How thoroughly loading checks a file. Either way the structure is checked, so that no content of
/// a file, damaged or crafted, can lead a query out of its arrays.
enum class Verification : std::uint8_t {
    full,     ///< compares the checksums of all sections too: any damage is found; reads all bytes
    structure ///< leaves the checksums out
};

/// How a saved structure comes into memory.
enum class FileAccess : std::uint8_t {
    read, ///< into memory of its own, in huge pages where the system has them: the file may change
    /// The file's own pages, which processes share and which are read when they are touched. The file
    /// must not change while it is used: where somebody shortens it, the system ends the process
    /// (SIGBUS). Replacing or deleting it does no harm.
    map
};

} // namespace proxima
