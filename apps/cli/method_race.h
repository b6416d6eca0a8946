// Builds one octree by several overlap methods and depths and compares time and result: the
// measurement behind `proxima compare` and Table 3.3.
#pragma once

#include "cli/names.h"
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/thesis.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace proxima {

struct MethodRaceOptions {
    std::vector<int> depths = {1, 2, 3, 4, 5};
    std::vector<OverlapMethod> methods = {all_methods.begin(), all_methods.end()};
    std::uint32_t threshold = 1;
    Exactness exactness = Exactness::rounded;
    int repeats = 3; ///< runs of each, interleaved; one that takes over a second runs once
    Execution execution = {};
};

struct RaceRow {
    int depth = 0;
    OverlapMethod method{};
    std::uint64_t total = 0;
    std::uint64_t references = 0;
    double seconds = 0.0; ///< median, without inner/outer classification: the overlap tests' share
    std::optional<double> ratio_to_separating_axis; ///< its seconds over theirs, where both ran
    bool same_as_first = true; ///< same cells and lists as the depth's first method
};

/// One row per depth and method. Errors as build_octree.
[[nodiscard]] Result<std::vector<RaceRow>> race_methods(const TriangleMesh& mesh,
                                                        const MethodRaceOptions& options);

/// "1 thread", "2 threads": the number that works.
[[nodiscard]] std::string threads_text(Threads threads);

/// A table for people.
[[nodiscard]] std::string race_text(const std::vector<RaceRow>& rows);

/// One sentence: whether all methods gave the same octrees.
[[nodiscard]] std::string agreement_text(const std::vector<RaceRow>& rows);

} // namespace proxima
