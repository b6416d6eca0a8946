// The convex polyhedron that half-spaces have in common.
//
// Around a point c inside, plane n . x = d becomes the point n / (d - n . c), and the corners of
// the polyhedron are the facets of the hull of those points: duality [preparata-1979]. A facet
// through the origin is a corner at infinity, a ray. c is the centre of the largest ball, by the
// simplex method.
#pragma once

#include "base/progress.h"
#include "base/result.h"
#include "minkowski/convex_polyhedron.h"

#include <span>

namespace proxima {

/// How far outside a half-space a corner may be, per distance from the origin.
inline constexpr double half_space_tolerance = 1e-14;
/// How far a ray of length 1 may lead out of a half-space, per unit along it.
inline constexpr double half_space_ray_tolerance = 1e-11;
/// The smallest ball that counts as a volume, per largest offset.
inline constexpr double min_ball_radius = 1e-12;

/// All x with normal . x <= offset for every plane; the normals may have any length. Corners are
/// solved from their planes in extended precision, then rounded. Corners closer than 1e-12 of the
/// largest distance from the origin (or 1e-3 of the largest ball's radius, if less) become one, and
/// rays within 1e-9; what is farther than 1e11 times the largest offset is a ray. The exact hull of
/// these is returned, so a facet of more than three corners may come apart into facets that differ
/// by rounding.
///
/// What is returned has been checked. With the planes' normals of length 1 and c the centre of the
/// largest ball: every corner p is in every half-space to half_space_tolerance * (|p| + |c|), every
/// ray of length 1 along it to half_space_ray_tolerance, and every facet lies in one of the planes,
/// as far as corners that became one allow. What fails is refused. In an unbounded set, |c| may be
/// several times the largest offset.
///
/// Errors: invalid_argument (NaN or infinity; a normal of no length; no point in common; nothing
/// with a volume in common, or less than a ball of radius min_ball_radius times the largest offset;
/// a whole line in common; not right to the tolerances above), limit_exceeded (a normal too
/// long, or an offset per length of its normal beyond max_polyhedron_coordinate), cancelled.
/// O(n log n) for the corners, n times the simplex steps (a few dozen), and O(n m) for the check of
/// m corners and facets.
[[nodiscard]] Result<ConvexPolyhedron> polyhedron_of_half_spaces(std::span<const HalfSpace> planes,
                                                                 Progress* progress = nullptr);

} // namespace proxima
