// What the thesis's patches of rings miss, by the hand's speed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace proxima::bench {

struct PatchTableOptions {
    std::uint64_t ticks = 1000; ///< of each script
    double radius = 0;          ///< m, of the proxy
    std::string keep;           ///< folder of octrees; empty for none
};

/// A device goes along the hand's scripts at 0.1, 0.25, 0.5 and 1 m/s, and touches patches that
/// come a period of the collision loop (100 Hz) after they were begun; beside it a proxy that
/// touches all triangles. Prints a row for each speed and depth. Returns the exit status.
[[nodiscard]] int run_patch_table(const std::string& mesh, const PatchTableOptions& options);

} // namespace proxima::bench
