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
    const auto megabytes = [](std::uint64_t bytes) { return (bytes + 999'999) / 1'000'000; };
    return fail(ErrorCode::budget_exceeded,
                concat(what, " needs at least ", megabytes(needed), " MB, the budget is ",
                       megabytes(limit), " MB: ", advice));
}

} // namespace proxima
