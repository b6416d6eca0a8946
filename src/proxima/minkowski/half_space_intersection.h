// The convex polyhedron that half-spaces have in common.
//
// Around a point c inside, plane n . x = d becomes the point n / (d - n . c), and the corners of
// the polyhedron are the facets of the hull of those points: duality [preparata-1979]. A facet
// through the origin is a corner at infinity, a ray. c is the centre of the largest ball, by the
// simplex method.
#pragma once

#include "proxima/base/result.h"
#include "proxima/minkowski/convex_polyhedron.h"

#include <span>

namespace proxima {

/// All x with normal . x <= offset for every plane; the normals may have any length. Corners are
/// rounded (corners within 1e-12 of the size become one, and rays within 1e-9) and their exact hull
/// is returned, so a facet of more than three corners may come apart into facets that differ by
/// rounding. Errors: invalid_argument (NaN or infinity, a normal of no length, no point in common,
/// nothing with a volume in common, a whole line in common). O(n log n) and n times the simplex
/// steps, a few dozen.
[[nodiscard]] Result<ConvexPolyhedron> polyhedron_of_half_spaces(std::span<const HalfSpace> planes);

} // namespace proxima
