// What Minkowski sums cost by the thesis's methods (thesis 3.2, 3.3).
//
//     auto counted = count_minkowski_sum(MinkowskiMethod::hull, a, b);   // counted->counts.flops()
#pragma once

#include "minkowski/operation_counts.h"
#include "proxima/execution.h"
#include "proxima/minkowski_sum.h"
#include "proxima/result.h"
#include "proxima/thesis.h"

namespace proxima {

/// A sum and what it cost.
struct CountedSum {
    MinkowskiSum sum;
    OperationCounts counts;
};

/// Like minkowski_sum_by, on numbers that count what is done to them: the thesis's Table 3.2 for
/// any operands. Of `arcs` the signs of the Gaussian maps are counted, filters included; its merging
/// of faces, and the few signs that exact numbers decide, are not arithmetic of a scalar.
[[nodiscard]] Result<CountedSum> count_minkowski_sum(MinkowskiMethod method,
                                                     const ConvexPolyhedron& a,
                                                     const ConvexPolyhedron& b,
                                                     Progress* progress = nullptr);

} // namespace proxima
