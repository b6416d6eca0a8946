// Minkowski sums on numbers that count what is done to them (thesis Table 3.2).
#pragma once

#include "minkowski/operation_counts.h"
#include "proxima/minkowski_sum.h"

namespace proxima {

/// What a sum cost.
struct CountedSum {
    MinkowskiSum sum;
    OperationCounts counts;
};

/// Sums on numbers that count what is done to them: the thesis's Table 3.2 for any operands. Of
/// `arcs` the signs of the Gaussian maps are counted, filters included; its merging of faces, and
/// the few signs that exact numbers decide, are not arithmetic of a scalar. Errors as
/// minkowski_sum.
[[nodiscard]] Result<CountedSum> count_minkowski_sum(const ConvexPolyhedron& a,
                                                     const ConvexPolyhedron& b,
                                                     const MinkowskiOptions& options = {});

} // namespace proxima
