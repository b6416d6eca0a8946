#include "base/parallel.h"

#include <algorithm>
#include <optional>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#if defined(__SANITIZE_THREAD__)
#define PROXIMA_THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define PROXIMA_THREAD_SANITIZER 1
#endif
#endif

#ifdef PROXIMA_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace proxima {

namespace {

/// oneTBB ends the process, or hangs, where the system gives no more threads.
constexpr int most_threads = 1024;

// The sanitizer cannot see into the uninstrumented thread library: these tell it that work handed
// over happens after the hand-over, and the caller goes on after all work. The flags have fixed
// addresses, because a task must acquire before it reads anything, its own captures included.
char fork_flag = 0;
char join_flag = 0;

void release([[maybe_unused]] char* flag)
{
#ifdef PROXIMA_THREAD_SANITIZER
    __tsan_release(flag);
#endif
}

void acquire([[maybe_unused]] char* flag)
{
#ifdef PROXIMA_THREAD_SANITIZER
    __tsan_acquire(flag);
#endif
}

} // namespace

int thread_count(Threads threads) noexcept
{
    return threads.count > 0 ? std::min(threads.count, most_threads)
                             : tbb::this_task_arena::max_concurrency();
}

void parallel_for(std::size_t count, Threads allowed, FunctionRef<void(std::size_t)> body)
{
    const auto threads = static_cast<int>(
        std::min<std::size_t>(static_cast<std::size_t>(thread_count(allowed)), count));
    if (threads <= 1) {
        for (std::size_t index = 0; index < count; ++index) body(index);
        return;
    }
    const auto task = [body](std::size_t index) {
        acquire(&fork_flag);
        body(index);
        release(&join_flag);
    };
    // More threads than processors are given only on demand, and refused with a line on stderr.
    std::optional<tbb::global_control> demand;
    if (threads > tbb::info::default_concurrency()) {
        demand.emplace(tbb::global_control::max_allowed_parallelism,
                       static_cast<std::size_t>(threads));
    }
    release(&fork_flag);
    tbb::task_arena arena(threads);
    arena.execute(
        [&] { tbb::parallel_for(std::size_t{0}, count, task, tbb::simple_partitioner()); });
    acquire(&join_flag);
}

} // namespace proxima
