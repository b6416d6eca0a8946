// Parallel loops. Only parallel.cpp knows the thread library, so that sanitizers see every
// hand-over and results never depend on how the work was split. Without oneTBB
// (PROXIMA_WITH_TBB=OFF) parallel_serial.cpp stands in for it: everything is on one thread.
#pragma once

#include "proxima/execution.h"
#include "proxima/function_ref.h"

#include <cstddef>

namespace proxima {

/// The number of threads that `threads` stands for, at least 1; 1 without oneTBB.
[[nodiscard]] int thread_count(Threads threads) noexcept;

/// Calls body(i) once for every i in [0, count), in any order, on at most `threads` threads;
/// returns when all are done. Each index is a task of its own: give it a chunk worth microseconds
/// or more. With one thread the calls are made in order on the calling thread. The body must not
/// throw.
void parallel_for(std::size_t count, Threads threads, FunctionRef<void(std::size_t)> body);

/// How many chunks of `chunk` items, the last one perhaps shorter, `count` items make.
[[nodiscard]] constexpr std::size_t chunk_count(std::size_t count, std::size_t chunk) noexcept
{
    return (count + chunk - 1) / chunk;
}

/// Like parallel_for, with a task for each chunk: calls body(first, end) for the ranges
/// [0, chunk), [chunk, 2 * chunk) and so on up to `count`. The number of a chunk is first / chunk.
void parallel_chunks(std::size_t count, std::size_t chunk, Threads threads,
                     FunctionRef<void(std::size_t first, std::size_t end)> body);

} // namespace proxima
