// Minkowski sums by the thesis's methods beside ours, and what each costs (thesis 3.2, 3.3).
//
//     auto sum = minkowski_sum_by(MinkowskiMethod::geometric, a, b);
//     auto counted = count_minkowski_sum(MinkowskiMethod::hull, a, b);   // counted->counts.flops()
#pragma once

#include "minkowski/operation_counts.h"
#include "proxima/execution.h"
#include "proxima/minkowski_sum.h"
#include "proxima/result.h"

namespace proxima {

/// How a sum is found. All three give the same one, but for rounding in the last two.
enum class MinkowskiMethod : std::uint8_t {
    arcs,      ///< minkowski_sum: overlay of the Gaussian maps; exact; the fast one
    geometric, ///< the thesis's pushing of planes (3.2); slow for more than a few dozen facets
    hull       ///< incremental hull of all pairs (3.3.2); slow for more than some hundred pairs
};

/// The sum of A and B. Errors: as minkowski_sum; of geometric and hull also invalid_argument
/// (unbounded operands: see unbounded_sum.h; a flat sum; rounding broke the hull) and
/// limit_exceeded (operands so large that they would take hours).
[[nodiscard]] Result<MinkowskiSum> minkowski_sum_by(MinkowskiMethod method,
                                                    const ConvexPolyhedron& a,
                                                    const ConvexPolyhedron& b,
                                                    Progress* progress = nullptr);

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
