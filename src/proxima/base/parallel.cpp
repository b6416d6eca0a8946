#include "proxima/base/parallel.h"

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

// The sanitizer cannot see into the uninstrumented thread library: these tell it that work handed
// over happens after the hand-over, and the caller goes on after all work.
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
    return threads.count > 0 ? threads.count : tbb::this_task_arena::max_concurrency();
}

void detail::parallel_for(std::size_t count, int threads, LoopBody body, void* context)
{
    if (threads <= 1 || count <= 1) {
        for (std::size_t index = 0; index < count; ++index) body(context, index);
        return;
    }
    char fork = 0;
    char join = 0;
    release(&fork);
    tbb::task_arena arena(threads);
    arena.execute([&] {
        tbb::parallel_for(
            std::size_t{0}, count,
            [&](std::size_t index) {
                acquire(&fork);
                body(context, index);
                release(&join);
            },
            tbb::simple_partitioner());
    });
    acquire(&join);
}

} // namespace proxima
