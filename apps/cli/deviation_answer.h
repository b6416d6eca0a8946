// The numbers of `proxima deviation`, as text and as JSON.
#pragma once

#include "proxima/mesh_deviation.h"

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>

namespace proxima {

/// From one mesh to the other.
struct OneWayDeviation {
    GreatestDeviation greatest;
    std::optional<MeanDeviation> mean; ///< none where it is not wanted, or of a mesh without area
    double greatest_seconds = 0;
    double mean_seconds = 0;
};

/// A block of lines for each way, and for both where there are two.
[[nodiscard]] std::string deviation_text(std::span<const OneWayDeviation> ways,
                                         const DistanceBounds& hausdorff);

/// The keys a_to_b, b_to_a, hausdorff and both_ways, the last three where there are two ways. With
/// lists of places where these were asked for.
[[nodiscard]] nlohmann::ordered_json deviation_json(std::span<const OneWayDeviation> ways,
                                                    const DistanceBounds& hausdorff,
                                                    bool has_places);

} // namespace proxima
