// What `proxima proximity` was asked for, and the runs that answer it, one per method.
#pragma once

#include "cli/session.h"
#include "proxima/proximity/thesis_labels.h"

#include <cstdint>
#include <string>
#include <vector>

namespace proxima {

enum class ProximityMethod : std::uint8_t { thesis };

struct ProximityCommandOptions {
    std::string model;
    ProximityMethod method = ProximityMethod::thesis;
    std::vector<int> depths = {5};
    KindThresholds thresholds = {};
    double margin = 0.5;
    std::uint64_t budget_mb = 0;
    std::vector<std::string> histograms;
};

/// Builds the thesis's proximity octree to each of the depths, counts it, and writes histograms.
[[nodiscard]] Status run_thesis_proximity(const ProximityCommandOptions& options, Session& session);

} // namespace proxima
