// The thesis's three loops at once, by the clock: servo 1,000 Hz, collision 100 Hz, graphics 50 Hz.
// Twice: the servo loop asks the octree itself, and it touches the patches of the collision loop.
#pragma once

#include <cstdint>
#include <string>

namespace proxima::bench {

struct TouchLoopOptions {
    double seconds = 60;
    std::string script = "slide";
    bool direct = true;  ///< whether the servo loop asks the octree itself
    bool patches = true; ///< and whether it touches patches, in another run
    std::string keep;    ///< folder of octrees; empty for none
};

/// Runs the loops on a mesh, each way, and prints what the servo loop met. Returns the exit status.
[[nodiscard]] int run_loops(const std::string& mesh, const TouchLoopOptions& options);

} // namespace proxima::bench
