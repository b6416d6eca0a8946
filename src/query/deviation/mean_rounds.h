// Sums of the bounds of the mean deviation over all of A, shared between threads.
//
// First each triangle is looked at. What is left of those that want many cuts is searched in further
// rounds, part by part: so one large triangle keeps all threads busy, as many small ones do.
#pragma once

#include "proxima/mesh_deviation.h"
#include "proxima/result.h"
#include "query/deviation/mean_search.h"
#include "query/deviation/surface_pair.h"

#include <cstdint>

namespace proxima {

/// `tolerance` and `root`, about the root mean square, are in the pair's units. The same bits for any
/// number of threads. Stages "mean deviation" and "parts of large triangles". Errors: budget_exceeded,
/// cancelled.
[[nodiscard]] Result<MeanSums> sum_means(const SurfacePair& pair, const MeasuredVertices& vertices,
                                         const MeanDeviationOptions& options, double tolerance,
                                         double root, std::uint64_t max_splits);

} // namespace proxima
