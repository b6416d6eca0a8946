// What the tasks of a search find, within a memory budget.
#pragma once

#include "base/memory_budget.h"
#include "proxima/execution.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

/// A list for each task. Lists that grow have up to twice their size, or three times while they move, and the answer
/// is made while they are there: three times what is found.
template <class Found>
class FoundLists {
public:
    /// `taken`: bytes of the budget that are in use besides.
    FoundLists(std::size_t tasks, MemoryBudget budget, std::uint64_t taken) : lists_(tasks)
    {
        const std::uint64_t bytes = budget_bytes(budget);
        const std::uint64_t used = taken + bytes_of_tasks(tasks);
        most_ = bytes > used ? (bytes - used) / (3 * sizeof(Found)) : 0;
    }

    [[nodiscard]] static constexpr std::uint64_t bytes_of_tasks(std::size_t tasks) noexcept
    {
        return tasks * sizeof(std::vector<Found>);
    }

    /// Of one task at a time.
    void add(std::size_t task, const Found& found)
    {
        lists_[task].push_back(found);
        ++count_;
    }
    /// More than the budget holds were found: tasks should end. Each may have added one too many.
    [[nodiscard]] bool is_over() const noexcept { return count_ > most_; }
    [[nodiscard]] std::uint64_t most() const noexcept { return most_; }

    /// All of it, task by task; the lists are empty then.
    [[nodiscard]] std::vector<Found> take()
    {
        std::vector<Found> all;
        all.reserve(count_);
        for (std::vector<Found>& own : lists_) {
            all.insert(all.end(), own.begin(), own.end());
            own = {};
        }
        return all;
    }

private:
    std::vector<std::vector<Found>> lists_;
    std::uint64_t most_ = 0;
    std::atomic<std::uint64_t> count_ = 0;
};

} // namespace proxima
