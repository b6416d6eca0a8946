// Quadtrees of convex sets in the plane by Minkowski sums with index tracking: thesis 3.4, 3.5 and
// 4.3 where it draws them (figures 2.3, 2.4 and 4.1).
//
//     a set (+) the square of half edge 1     one sum per set
//     the same at half edge 2^-d              its lines' offsets from the same supports
//     the square around c meets the set       where c lies in that sum
#pragma once

#include "minkowski/convex_polygon.h"
#include "proxima/geometry.h"
#include "proxima/octree.h"
#include "proxima/result.h"

#include <span>
#include <vector>

namespace proxima {

/// A leaf: a closed square and the sets that it meets, ascending.
struct QuadtreeLeaf {
    Vec2 center = Vec2::Zero();
    double half = 0.0; ///< edge
    int depth = 0;
    std::vector<int> sets = {};
};

struct QuadtreeOptions {
    Vec2 center = Vec2::Zero(); ///< of the root
    double half = 1.0;          ///< half edge of the root
    int max_depth = 5;
    std::size_t threshold = 0; ///< a cell splits while it meets more sets
    Subdivision subdivision = Subdivision::adaptive;
};

/// Leaves in Morton order. Errors: as planar_sum.
[[nodiscard]] Result<std::vector<QuadtreeLeaf>> quadtree_leaves(std::span<const ConvexPolygon> sets,
                                                                const QuadtreeOptions& options);

/// The edges of a convex polygon as segments. \pre bounded, three corners or more
[[nodiscard]] Result<std::vector<ConvexPolygon>> edges_of(const ConvexPolygon& polygon);

/// The exterior Voronoi regions of a convex polygon: of its corners (cones), then of its edges
/// (strips without an end; edge i runs from corner i). \pre bounded, three corners or more
[[nodiscard]] Result<std::vector<ConvexPolygon>> voronoi_regions_of(const ConvexPolygon& polygon);

/// Whether the point is in the closed polygon, but for rounding. \pre as above
[[nodiscard]] bool is_inside(const ConvexPolygon& polygon, const Vec2& point);

} // namespace proxima
