// Parallel loops. Only parallel.cpp knows the thread library, so that sanitizers see every
// hand-over and results never depend on how the work was split.
#pragma once

#include "proxima/execution.h"
#include "proxima/function_ref.h"

#include <cstddef>

namespace proxima {

/// The number of threads that `threads` stands for, at least 1.
[[nodiscard]] int thread_count(Threads threads) noexcept;

/// Calls body(i) once for every i in [0, count), in any order, on at most `threads` threads;
/// returns when all are done. Each index is a task of its own: give it a chunk worth microseconds
/// or more. With one thread the calls are made in order on the calling thread. The body must not
/// throw.
void parallel_for(std::size_t count, Threads threads, FunctionRef<void(std::size_t)> body);

} // namespace proxima
