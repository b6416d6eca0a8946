// Does a triangle touch an axis-aligned box? Exact for doubles, both sets closed.
//
//     boxes apart? -> corner inside? -> plane and 9 edge half-spaces in double, with error bounds
//                                        -> what is left: signs of exact_predicates.h
//
// The Minkowski sum of triangle and box has at most 17 facets: 6 of the box (the comparison of
// boxes), 2 of the triangle's plane, and 9 = 3 axes x 3 edges (thesis 3.3; the same tests in
// [schwarz-2010]). Seen along axis k, the nine say: the projected box is not beyond any edge
// of the projected triangle. With u, w the axes after k,
//
//     L(x) = (b - a)_u (x - a)_w - (b - a)_w (x - a)_u       edge a -> b
//     N_k  = L(c), the same for all three edges, the normal's component k
//
// and the sets are apart iff the maximum of L over the box is negative where N_k >= 0, or its
// minimum positive where N_k < 0. Where N_k = 0 the projected triangle is a segment or a point and
// its three edges supply both sides, so degenerate triangles need no case of their own.
#pragma once

#include "proxima/geometry.h"

namespace proxima {

/// What arithmetic in double says of a triangle and a box.
struct TriangleBoxVerdict {
    bool overlaps = true; ///< false only if they are apart
    bool certain = false; ///< true: `overlaps` is the exact answer; false: it is true for safety
};

/// The stages in double only: never says "apart" wrongly, and is certain of nearly all pairs,
/// exactly touching ones that are parallel to axes included.
/// \pre all finite, box.lower <= box.upper. Cost: 10 to 100 ns. Thread safe, no allocation.
[[nodiscard]] TriangleBoxVerdict triangle_box_filter(const Triangle& triangle,
                                                     const Box& box) noexcept;

/// Whether the closed triangle (or segment, or point) and the closed box share a point. Exact.
/// \pre all finite, box.lower <= box.upper. Cost: that of the filter, 1 us where it is not certain.
/// Thread safe, no allocation.
[[nodiscard]] bool triangle_overlaps_box(const Triangle& triangle, const Box& box) noexcept;

} // namespace proxima
