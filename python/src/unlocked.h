// The time in which a thread of Python works without Python's lock.
#pragma once

#include <cxxabi.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

namespace proxima::python {

/// Lets go of Python's lock until its end. A thread that wants the lock back after the interpreter has
/// ended, as daemon threads do, stays here for ever, as Python itself lets it from 3.14 on. Before, it
/// unwinds the thread's stack, which pybind11's guard turns into an end of the process.
class Unlocked {
public:
    Unlocked() noexcept : state_(PyEval_SaveThread()) {}
    ~Unlocked()
    {
        try {
            PyEval_RestoreThread(state_);
        } catch (const abi::__forced_unwind&) {
            for (;;) pause();
        }
    }
    Unlocked(const Unlocked&) = delete;
    Unlocked& operator=(const Unlocked&) = delete;

private:
    PyThreadState* state_;
};

} // namespace proxima::python
