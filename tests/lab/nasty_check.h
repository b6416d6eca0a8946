// Every operation on one mesh: right against its oracle, or refused in words.
#pragma once

#include "oracles/nasty_corpus.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace proxima::testing {

/// What came of one operation.
struct NastyOutcome {
    std::uint64_t comparisons = 0; ///< with its oracle
    std::string refusal;           ///< the error's words
    std::string wrong;             ///< what the oracle says otherwise, or an error without words
    bool left_out = false; ///< for its time grows with the square of the triangles of a vertex
    double seconds = 0;    ///< the oracle's included
};

/// The work of one check: operations compare that many points, rays and so on.
struct NastyEffort {
    int queries = 24;
    int ticks = 100;
    std::filesystem::path folder; ///< for files, which are removed
};

/// The names of all operations, in the order of check_nasty().
[[nodiscard]] std::vector<std::string> nasty_operations();

/// Does all operations. Brute force looks at every triangle for every query, and at every pair of
/// triangles where the mesh has few.
[[nodiscard]] std::vector<NastyOutcome> check_nasty(const oracle::NastyMesh& nasty,
                                                    const NastyEffort& effort);

} // namespace proxima::testing
