#include "base/memory_budget.h"

#include "base/text.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <sys/resource.h>
#include <unistd.h>

namespace proxima {

namespace {

/// The limit that a container sets on its processes; "max" or no file where there is none.
std::uint64_t container_limit()
{
    std::uint64_t limit = 0;
    std::ifstream file("/sys/fs/cgroup/memory.max");
    return file >> limit ? limit : std::numeric_limits<std::uint64_t>::max();
}

/// The limit that `ulimit -v` sets; the largest number where there is none.
std::uint64_t address_space_limit()
{
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
        return std::numeric_limits<std::uint64_t>::max();
    return limit.rlim_cur;
}

} // namespace

std::uint64_t budget_bytes(MemoryBudget budget)
{
    if (budget.bytes != 0) return budget.bytes;
    const auto pages = sysconf(_SC_PHYS_PAGES);
    const auto page_size = sysconf(_SC_PAGE_SIZE);
    if (pages <= 0 || page_size <= 0) return std::uint64_t{1} << 31U;
    const auto memory = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_size);
    return std::min({memory, container_limit(), address_space_limit()}) / 4 * 3;
}

Status check_budget(MemoryBudget budget, std::uint64_t needed, std::string_view what,
                    std::string_view advice)
{
    const auto limit = budget_bytes(budget);
    if (needed <= limit) return {};
    constexpr std::uint64_t megabyte = 1'000'000;
    const std::string needed_text =
        concat(needed / megabyte + (needed % megabyte != 0 ? 1 : 0), " MB");
    // Rounded the other way, so that what does not fit looks so.
    const std::string limit_text =
        limit < megabyte ? concat(limit, " bytes") : concat(limit / megabyte, " MB");
    return fail(ErrorCode::budget_exceeded, concat(what, " needs at least ", needed_text,
                                                   ", the budget is ", limit_text, ": ", advice));
}

} // namespace proxima
