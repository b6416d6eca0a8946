// Parallel loops. The only room that knows the thread library, so that sanitizers see every
// hand-over and results never depend on how the work was split.
#pragma once

#include <cstddef>
#include <type_traits>

namespace proxima {

/// How many threads an operation may use. 0 = all that the machine offers.
struct Threads {
    int count = 0;
};

/// The number of threads that `threads` stands for, at least 1.
[[nodiscard]] int thread_count(Threads threads) noexcept;

namespace detail {
using LoopBody = void (*)(void* context, std::size_t index);
void parallel_for(std::size_t count, int threads, LoopBody body, void* context);
} // namespace detail

/// Calls body(i) once for every i in [0, count), in any order, on at most `threads` threads;
/// returns when all are done. Each index is a task of its own: give it a chunk worth microseconds
/// or more. With one thread the calls are made in order on the calling thread. The body must not
/// throw.
template <class Body>
void parallel_for(std::size_t count, Threads threads, Body&& body)
{
    using Callable = std::remove_reference_t<Body>;
    detail::parallel_for(
        count, thread_count(threads),
        [](void* context, std::size_t index) { (*static_cast<Callable*>(context))(index); },
        const_cast<void*>(static_cast<const void*>(&body)));
}

} // namespace proxima
