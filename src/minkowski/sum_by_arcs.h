// The Minkowski sum by overlaying Gaussian maps.
//
//     facets of A   with the face of B that reaches farthest along their normals
//     facets of B   the same the other way, unless A has a facet of that normal
//     pairs of edges whose arcs cross: parallelograms
//
// Crossings are found by walking along every arc of A through the regions of B: in the region of v
// an arc that does not end leaves across the edge (v, w) that has its own facets on either side of
// the arc, or through a facet's normal where that lies on the arc [fogel-2007, fukuda-2004].
#pragma once

#include "proxima/execution.h"
#include "proxima/minkowski_sum.h"
#include "proxima/result.h"

namespace proxima::detail {

/// Instantiated for double and Counted. Errors: cancelled; invalid_argument (a flat sum that holds
/// a line).
template <class Scalar = double>
[[nodiscard]] Result<MinkowskiSum> sum_by_arcs(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                               Progress* progress);

} // namespace proxima::detail
