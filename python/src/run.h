// Work without Python's lock, which Ctrl-C and a progress callback can stop.
#pragma once

#include "errors.h"
#include "proxima/execution.h"
#include "proxima/function_ref.h"

#include <optional>
#include <pybind11/pybind11.h>
#include <type_traits>
#include <utility>

namespace proxima::python {

/// How long work may take: short work runs in the caller's thread and cannot be stopped.
enum class Duration : std::uint8_t { brief, lengthy };

/// Runs work(progress) without Python's lock. Lengthy work runs in a thread of its own, while the
/// caller handles signals twenty times a second and calls callback(stage, fraction) unless that is
/// None. An exception of either, or a callback that returns False, cancels the work.
void run_unlocked(const py::object& callback, Duration duration, FunctionRef<void(Progress*)> work);

/// The value of the Result that work(progress) returns.
template <class Work>
auto run(const py::object& callback, Duration duration, Work&& work)
{
    std::optional<std::invoke_result_t<Work, Progress*>> result;
    run_unlocked(callback, duration, [&](Progress* progress) { result.emplace(work(progress)); });
    return value_of(*std::move(result));
}

/// The number of threads of an argument: 0 = all.
[[nodiscard]] Threads threads_of(Integer count);

} // namespace proxima::python
