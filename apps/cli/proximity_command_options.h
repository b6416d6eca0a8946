// What `proxima proximity` was asked for, and the runs that answer it, one per method.
#pragma once

#include "cli/session.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include <cstdint>
#include <string>
#include <vector>

namespace proxima {

enum class ProximityMethod : std::uint8_t { general, thesis };

struct ProximityCommandOptions {
    std::string model;
    ProximityMethod method = ProximityMethod::general;
    std::vector<int> depths;        ///< filled with the method's own depth where none is named
    KindThresholds thresholds = {}; ///< of the thesis's method alone
    double margin = 0.5;
    double flat = 0; ///< of the thesis's method: edges of 1 - cos below it are flat; 0: its default
    std::uint64_t lists_mb = 0;  ///< of the general method; 0: its own
    std::uint64_t budget_mb = 0; ///< of the thesis's build; 0: 3/4 of the machine's memory
    std::vector<std::string> histograms;
    std::vector<std::string> budget_curves; ///< of the general method: instead of all that
    std::string save;                       ///< .pxi file, of the general method and one depth
    std::vector<std::string> outs;          ///< .vtu and .htg, the same
};

/// Builds the proximity octree of any mesh to each of the depths, counts it, times queries, and
/// writes histograms.
[[nodiscard]] Status run_general_proximity(const ProximityCommandOptions& options,
                                           Session& session);

/// Builds the proximity octree with many budgets, times queries, and writes curves.
[[nodiscard]] Status run_budget_curve(const ProximityCommandOptions& options, Session& session);

/// Builds the thesis's proximity octree to each of the depths, counts it, and writes histograms.
[[nodiscard]] Status run_thesis_proximity(const ProximityCommandOptions& options, Session& session);

} // namespace proxima
