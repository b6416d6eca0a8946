// Some of a set of queries, for slow peers.
#pragma once

#include "proxima/geometry.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima::bench {

/// Runs of neighbours, evenly spaced over the set, so that a coherent set stays coherent.
struct QuerySample {
    std::vector<Vec3> points;
    std::vector<std::uint32_t> places; ///< in the whole set
};

/// At least `count` points of a set. \pre 0 < count <= points.size()
[[nodiscard]] QuerySample sample_of(std::span<const Vec3> points, std::size_t count);

} // namespace proxima::bench
