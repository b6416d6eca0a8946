// What benchmarks that are programs of their own have in common: time, medians, the usual meshes,
// and the way from the command line to the exit status.
#pragma once

#include "instruction_set.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

namespace proxima::bench {

/// Processor time of this process: what others run does not count.
inline double processor_seconds()
{
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// \pre not empty
inline double median(std::vector<double> values)
{
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Options that all of them take.
struct CommonOptions {
    int rounds = 7;
    std::uint64_t seed = 1;
    std::vector<std::string> meshes; ///< empty: the usual ones
};

/// Adds --rounds, --seed and --mesh.
inline void add_common_options(CLI::App& app, CommonOptions& options)
{
    app.add_option("--rounds", options.rounds, "Passes, of which medians are taken")
        ->check(CLI::Range(1, 1000));
    app.add_option("--seed", options.seed, "Seed of what is random");
    app.add_option("--mesh", options.meshes, "A file or a built-in instead of the usual meshes")
        ->allow_extra_args(false);
}

/// Those asked for; else a sphere, Debian's bunny and the mesh of PROXIMA_BENCH_MESH, as far as
/// they are there.
inline std::vector<std::string> meshes_of(const CommonOptions& options)
{
    if (!options.meshes.empty()) return options.meshes;
    std::vector<std::string> names = {"sphere:100x100"};
    const char* const bunny = "/usr/share/glmark2/models/bunny.obj";
    if (std::filesystem::exists(bunny)) names.emplace_back(bunny);
    if (const char* const own = std::getenv("PROXIMA_BENCH_MESH")) names.emplace_back(own);
    return names;
}

/// All of main: --simd, which PROXIMA_SIMD gives as well, and the options that `add_options` gives the parser are read, then `run` makes the exit
/// status.
template <class AddOptions, class Run>
int run_program(int argc, char** argv, const char* title, const AddOptions& add_options,
                const Run& run) noexcept
try {
    CLI::App app(title);
    std::string simd;
    app.add_option("--simd", simd, "Instruction set of kernels, such as AVX2, instead of the best")
        ->envname("PROXIMA_SIMD");
    add_options(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    return use_instruction_set(simd) ? run() : 2;
} catch (const std::exception& error) {
    (void)std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

} // namespace proxima::bench
