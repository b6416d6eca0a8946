// Servo loop and graphics loop at once, by the clock: 1,000 Hz and 50 Hz.
#pragma once

#include <cstdint>
#include <string>

namespace proxima::bench {

struct TouchLoopOptions {
    double seconds = 60;
    std::string script = "slide";
    std::string keep; ///< folder of octrees; empty for none
};

/// Runs the loops on a mesh, and prints what the servo loop met. Returns the exit status.
[[nodiscard]] int run_loops(const std::string& mesh, const TouchLoopOptions& options);

} // namespace proxima::bench
