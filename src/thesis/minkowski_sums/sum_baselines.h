// The thesis's ways to a Minkowski sum, for any two bounded polyhedra: MinkowskiMethod::geometric
// and MinkowskiMethod::hull (thesis 3.2.1 and 3.3.2).
//
//     geometric   candidate normals (facets of A, of B, edges of A x edges of B), each pushed both
//                 ways over all sums of vertices: what touches three of them not in a line stays
//     hull        the incremental convex hull of all sums of vertices
//
// In doubles, with ties up to what rounding can make; exact on small whole numbers. Both give
// planes and the pairs that lie in them; a pair in fewer than three facets is no corner of the sum
// and is eliminated (3.2.1). They are what minkowski_sum's `arcs` is measured and tested against.
#pragma once

#include "proxima/execution.h"
#include "proxima/minkowski_sum.h"
#include "proxima/result.h"

namespace proxima::detail {

/// No more pairs of vertices are summed by the baselines.
inline constexpr std::size_t max_baseline_pairs = 4096;

/// Instantiated, like the next, for double and Counted. Errors: invalid_argument (unbounded
/// operands, or a flat sum), limit_exceeded, cancelled.
template <class Scalar = double>
[[nodiscard]] Result<MinkowskiSum>
sum_by_geometric_method(const ConvexPolyhedron& a, const ConvexPolyhedron& b, Progress* progress);

/// Errors: the same, and invalid_argument where rounding broke the hull.
template <class Scalar = double>
[[nodiscard]] Result<MinkowskiSum> sum_by_hull(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                               Progress* progress);

} // namespace proxima::detail
