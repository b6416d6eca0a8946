// Questions to a Minkowski sum: is a point in it, how far, how deep, which way out (thesis 3.1,
// 3.6.1, 3.6.4).
//
// With the mirrored B, A (+) (-B) answers for the pair: B moved by t overlaps A exactly if t is in
// it, the distance of t from it is the distance of the two, and the depth of t in it is how far B
// must move to let go.
#pragma once

#include "minkowski/minkowski_sum.h"

#include <cstdint>
#include <optional>

namespace proxima {

/// Whether the closed sum holds the point, for the doubles given: exact. O(facets). Thread safe, no
/// allocation. \pre point finite
[[nodiscard]] bool contains(const MinkowskiSum& sum, const Vec3& point) noexcept;

/// The place of the surface that is nearest to a point.
struct SurfacePoint {
    double distance = 0; ///< negative inside; in the mesh's units
    Vec3 nearest = Vec3::Zero();
    Vec3 direction = Vec3::Zero();  ///< of length 1: outward to the surface from inside, from the
                                    ///< surface to the point from outside
    std::uint32_t facet = no_facet; ///< that holds `nearest`; none of a point or a segment
};

/// The signed distance of a point from the sum's surface, rounded; a flat sum has no inside. O(size
/// of the sum). Thread safe, no allocation. \pre point finite, the sum holds no line
[[nodiscard]] SurfacePoint signed_distance(const MinkowskiSum& sum, const Vec3& point) noexcept;

/// How far the point may go along a direction before it leaves the sum: infinity where it never
/// does (facets that it slides along but for rounding do not end it), nothing where it is not in
/// the sum. Thesis 3.1's directional penetration depth. O(facets). \pre point finite, direction of
/// length 1, the sum is no point, segment or polygon
[[nodiscard]] std::optional<double> directional_depth(const MinkowskiSum& sum, const Vec3& point,
                                                      const Vec3& direction) noexcept;

/// How two polyhedra stand to each other.
struct Separation {
    double distance = 0;           ///< negative where they overlap: the depth of penetration
    Vec3 direction = Vec3::Zero(); ///< of length 1 (none for segments that touch), from A to B:
                                   ///< moving B by -distance along it lets both just touch
};

/// Distance or minimum penetration depth of two polyhedra. Builds their sum: errors as
/// minkowski_sum, and invalid_argument where the sum holds a line.
[[nodiscard]] Result<Separation> separation(const ConvexPolyhedron& a, const ConvexPolyhedron& b);

} // namespace proxima
