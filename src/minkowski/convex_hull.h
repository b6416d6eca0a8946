// The convex hull of points, and of points that go on forever along rays, decided exactly.
//
//     auto box = convex_hull(corners);                 // 6 facets of 4 corners, not 12 triangles
//     auto wedge = convex_hull({p0, p1}, {n0, n1});    // p0 p1 swept along all between n0 and n1
#pragma once

#include "base/progress.h"
#include "base/result.h"
#include "minkowski/convex_polyhedron.h"

#include <span>

namespace proxima {

/// Coordinates of a polyhedron are no larger: products of them must stay finite.
inline constexpr double max_polyhedron_coordinate = 0x1p+300;

/// Whether a cone of these directions holds a whole line: some of them add up to nothing. Exact.
/// \pre finite, none zero
[[nodiscard]] bool span_a_line(std::span<const Vec3> rays);

/// The smallest convex set that holds the points and all half-lines from them along the rays. Any
/// dimension; points and rays that are not extreme are left out, the others keep their order. Exact
/// for the doubles given: facets of any number of corners, no two of them in one plane.
/// Errors: invalid_argument (no point; NaN or infinity; a ray of no length; rays that span a whole
/// line: such a set has no corner), limit_exceeded (a coordinate above max_polyhedron_coordinate,
/// or more than 2^31 vertices), cancelled. O(n log n) for n vertices in random order.
[[nodiscard]] Result<ConvexPolyhedron> convex_hull(std::span<const Vec3> points,
                                                   std::span<const Vec3> rays = {},
                                                   Progress* progress = nullptr);

} // namespace proxima
