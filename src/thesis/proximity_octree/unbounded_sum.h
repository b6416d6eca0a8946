// Unbounded Minkowski sums as the thesis makes them: cut, sum, remove (thesis 4.3.3, eq. 4.12).
//
//     1. every ray is cut off at a length: the polyhedron becomes bounded
//     2. the bounded ones are summed
//     3. facets that a cut-off ray leads through obstruct the sum there, and are removed
//
// minkowski_sum() needs none of this: it knows rays as corners at infinity. What is left here is
// the same for every length, as support is that of the points wherever no ray goes along a normal.
#pragma once

#include "proxima/execution.h"
#include "proxima/minkowski_sum.h"
#include "proxima/result.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// The polyhedron with its rays cut off `length` after each point that they leave from; rounded.
/// Errors: invalid_argument (a length that is not finite and above 0), limit_exceeded (a cut corner
/// beyond max_polyhedron_coordinate), cancelled.
[[nodiscard]] Result<ConvexPolyhedron> cut_rays(const ConvexPolyhedron& polyhedron, double length,
                                                Progress* progress = nullptr);

/// A sum made by cutting.
struct CutSum {
    MinkowskiSum intermediate;              ///< of the cut polyhedra, bounded
    std::vector<std::uint32_t> remaining;   ///< facets of it that bound the unbounded sum
    std::vector<std::uint32_t> obstructing; ///< facets of it that a ray leads through
};

/// A normal obstructs a ray of length 1 if it leads along it by more than this: cut corners are
/// rounded, so facets along a ray are not quite so.
inline constexpr double obstruction_tolerance = 1e-9;

/// A (+) B by (4.12). Errors: as cut_rays and minkowski_sum.
[[nodiscard]] Result<CutSum> sum_by_cutting(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                            double length, Progress* progress = nullptr);

} // namespace proxima
