// The sum of two parallel faces, edge by edge: the facet of a Minkowski sum (thesis 3.2 in 2D).
//
//        A's face         B's face              their edges, turned once around, make the sum's;
//         __               /|                   edges of one direction make one edge
//        |__|   (+)       /_|
//
// The vertices of the sum are pairs (i, j) of vertices; no coordinate is computed.
#pragma once

#include "proxima/minkowski_sum.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima::detail {

/// A face: one vertex, the two of an edge, or the loop of a facet counter-clockwise about the
/// common outward normal. Rays stand together.
struct FaceView {
    const ConvexPolyhedron* polyhedron = nullptr;
    std::span<const std::uint32_t> vertices;
};

/// Appends the corners of the sum of both faces, counter-clockwise about the normal, and says
/// whether it has an area. Exact. O(|a| + |b|), and O(their product) never.
/// \pre both faces are orthogonal to the normal; if both are unbounded, the sum holds no line
[[nodiscard]] bool append_face_sum(const FaceView& a, const FaceView& b,
                                   const ConvexPolyhedron::NormalFactors& normal,
                                   std::vector<SumCorner>& corners);

} // namespace proxima::detail
