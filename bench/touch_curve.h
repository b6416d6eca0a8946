// Tick time by the number of triangles: as a table and as a plot.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace proxima::bench {

/// All scripts of the simulated hand.
inline constexpr std::array touch_scripts = {"press", "slide", "stroke", "corner", "poke", "walk"};

struct TouchRaceOptions {
    std::uint64_t ticks = 20000; ///< of each script
    int replays = 5;
    double radius = 0; ///< m
    std::string keep;  ///< folder of octrees; empty for none
};

/// Times toruses of 1,024 triangles and more and the given meshes, each with the baseline of boxes
/// beside it, prints a table and writes it to each of `files`. Returns the exit status.
[[nodiscard]] int run_curve(const std::vector<std::string>& meshes, const TouchRaceOptions& options,
                            const std::vector<std::string>& files);

} // namespace proxima::bench
