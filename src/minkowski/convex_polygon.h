// Convex polygons in the plane, bounded and not, for the method of thesis 3.2 where it is drawn.
//
//     points   p0 p1 ... p(m-1)     corners, counter-clockwise
//     rays     none: bounded        two: from the last corner on forever, and from the first
//
//     edge e   p(e) -> p(e+1), the interior to its left, the outward normal to its right; of an
//              unbounded one edge m-1 goes out along rays()[0], and edge m comes in along rays()[1]
//
//         \      the region of the corner p0 that two rays bound (a Voronoi region, thesis 4.3.3):
//          p0    edges p0 -> rays()[0] (out) and rays()[1] -> p0 (in), interior between them
//         /
//
// One corner alone is a point, two a segment with an edge on either side; a half-line is a corner
// whose two rays are the same.
#pragma once

#include "geometry/exact_predicates.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <span>
#include <vector>

namespace proxima {

/// Immutable; make one by convex_polygon(). Members do not allocate and may be called from any
/// thread. Indices must be in range.
class ConvexPolygon {
public:
    [[nodiscard]] bool is_bounded() const noexcept { return rays_.empty(); }
    [[nodiscard]] std::span<const Vec2> points() const noexcept { return points_; }
    /// None, or two: the outgoing and the incoming edge's, both directions away from the corners.
    [[nodiscard]] std::span<const Vec2> rays() const noexcept { return rays_; }

    /// Edges, the unbounded ones among them.
    [[nodiscard]] int edge_count() const noexcept
    {
        const int corners = static_cast<int>(points_.size());
        if (!is_bounded()) return corners + 1;
        return corners == 1 ? 0 : corners;
    }
    /// The direction in which the boundary is walked with the interior to the left, exactly; z = 0.
    [[nodiscard]] Displacement direction(int edge) const noexcept;

private:
    friend Result<ConvexPolygon> convex_polygon(std::span<const Vec2>, std::span<const Vec2>);

    std::vector<Vec2> points_;
    std::vector<Vec2> rays_;
};

/// The smallest convex set that holds the points and all half-lines from them along the rays.
/// Exact: points that are no corners are left out. Corners given counter-clockwise keep their
/// numbers; others are numbered counter-clockwise from the first given one that is a corner, of an
/// unbounded polygon from the one where the boundary comes in. O(n log n).
/// Errors: invalid_argument (no point; NaN or infinity; a ray of no length; rays that span a whole
/// line), limit_exceeded (a coordinate above max_polyhedron_coordinate, or more than 2^20 points).
[[nodiscard]] Result<ConvexPolygon> convex_polygon(std::span<const Vec2> points,
                                                   std::span<const Vec2> rays = {});

/// A polygon's corners and, where it is unbounded, the ends of its rays cut at a length
/// (thesis 4.3.3, Figure 4.7): corners 0 .. real-1 are its own, the others the cut's, in the order
/// of a counter-clockwise walk. Edge e runs from corner e to the next; edge `closing` is the cut's
/// own, none (-1) if the polygon is bounded or a half-line.
struct CutPolygon {
    std::vector<Vec2> corners;
    int real = 0;
    int closing = -1;

    [[nodiscard]] bool is_bounded() const noexcept
    {
        return real == static_cast<int>(corners.size());
    }
    [[nodiscard]] int edge_count() const noexcept
    {
        return corners.size() == 1 ? 0 : static_cast<int>(corners.size());
    }
};

/// \pre length > 0, finite. The cut's corners are rounded.
[[nodiscard]] CutPolygon cut_polygon(const ConvexPolygon& polygon, double length);

} // namespace proxima
