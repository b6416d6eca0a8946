// How a check goes through large arrays: in tasks on several threads, watched, and such that the
// fault it names is the first one.
#pragma once

#include "base/parallel.h"
#include "base/progress.h"
#include "proxima/execution.h"
#include "proxima/result.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

class CheckWork {
public:
    /// Bytes of a task, and between looks at whether to stop.
    static constexpr std::uint64_t task_bytes = std::uint64_t{1} << 18U;

    explicit CheckWork(const Execution& execution) noexcept : execution_(execution) {}

    /// For one task's steps, in bytes.
    [[nodiscard]] StageSteps steps() const noexcept { return {execution_.progress, task_bytes}; }

    /// Calls check(task), which returns a Status, for all tasks; the error of the lowest that has
    /// one.
    template <class Check>
    [[nodiscard]] Status run(std::size_t tasks, Check&& check) const
    {
        std::vector<Status> found(tasks);
        parallel_for(tasks, execution_.threads, [&](std::size_t task) {
            found[task] = is_cancelled(execution_.progress)
                              ? Status(cancelled("checking the index"))
                              : check(task);
        });
        for (const Status& status : found) {
            if (!status) return status;
        }
        return {};
    }

    /// Calls check(first, end), which returns a Status, for chunks of items of `item_bytes` bytes
    /// each, a task of its own for each; the error of the lowest that has one.
    template <class Check>
    [[nodiscard]] Status run_chunks(std::size_t count, std::size_t item_bytes, Check&& check) const
    {
        const std::size_t chunk = task_bytes / item_bytes;
        return run(chunk_count(count, chunk), [&](std::size_t task) -> Status {
            const std::size_t first = task * chunk;
            const std::size_t end = std::min(count, first + chunk);
            Status status = check(first, end);
            advance_stage(execution_.progress, (end - first) * item_bytes);
            return status;
        });
    }

private:
    Execution execution_;
};

} // namespace proxima
