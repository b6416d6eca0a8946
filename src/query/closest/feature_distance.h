// Distances of single features from a point, in one arithmetic for every search.
//
//     vertex   |p - v|^2
//     edge     counts where p's foot is strictly between the ends, taken in ascending vertex id
//     face     counts where p's foot is strictly inside: the square of the height over its plane
//
// The feature with the least (squared distance, kind, id) is the answer of every search. The lanes
// of row_distance-inl.h compute the same bits, and vertices and edges give the same bits from
// whichever triangle they are met, so searches that skip some triangles and the one that skips none
// agree to the last bit. Distances are computed from differences of coordinates alone: they are
// right to a few roundings of these, however far the mesh is from the origin. The closest point is
// not part of them: it is rounded to the coordinates around it.
//
// Differences are scaled by a power of two before all else (RowScale), and squared distances are in
// its units.
// \pre for all: p is finite, scaled differences of coordinates below 2^500
#pragma once

#include "index/triangle_row.h"
#include "proxima/closest_feature.h"
#include "proxima/neighbourhood.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <limits>

namespace proxima {

/// What a feature does not have that does not count.
inline constexpr double no_distance = std::numeric_limits<double>::quiet_NaN();

/// Points whose scaled distance from the mesh is beyond this have all features at the distance
/// infinity, the first of them being the answer.
inline constexpr double endless_distance = 0x1p500;

/// |a - b|^2, its terms summed x, y, z.
[[nodiscard]] inline double squared_distance(const Vec3& a, const Vec3& b) noexcept
{
    const double x = a.x() - b.x();
    const double y = a.y() - b.y();
    const double z = a.z() - b.z();
    return x * x + y * y + z * z;
}

/// The scale that indexes of the mesh have. O(vertices).
[[nodiscard]] RowScale row_scale_of(const TriangleMesh& mesh) noexcept;

[[nodiscard]] double squared_distance(const Vec3& vertex, const Vec3& p,
                                      const RowScale& scale) noexcept;

/// Where on a segment the foot of a point is, from 0 at its first end to 1.
struct SegmentFoot {
    double squared = no_distance; ///< where the foot is not strictly between the ends
    double along = 0;
};
/// \pre `from` is the end of the lower vertex id
[[nodiscard]] SegmentFoot foot_between(const Vec3& from, const Vec3& to, const Vec3& p,
                                       const RowScale& scale) noexcept;

/// The foot of a point inside a triangle.
struct FaceFoot {
    double squared = no_distance; ///< where the foot is not strictly inside
    std::array<double, 3> weights{};
};
[[nodiscard]] FaceFoot foot_inside(const Triangle& face, const Vec3& p,
                                   const RowScale& scale) noexcept;

/// The foot of a point inside a triangle so thin that products of its sides say too little.
struct ThinInside {
    double squared = std::numeric_limits<double>::infinity(); ///< where it is not inside
    std::array<double, 3> weights{};
};
[[nodiscard]] ThinInside inside_of_thin(const Triangle& triangle, const Vec3& p,
                                        const RowScale& scale) noexcept;

/// Lowers `best` to the best of itself and all features of the triangle.
void offer_triangle(const TriangleMesh& mesh, const Topology& topology, TriangleId triangle,
                    const Vec3& p, const RowScale& scale, NearestFeature& best) noexcept;

/// Like offer_triangle, of a row.
void offer_row(const TriangleRow<float>& row, const Vec3& p, const RowScale& scale,
               NearestFeature& best) noexcept;
void offer_row(const TriangleRow<double>& row, const Vec3& p, const RowScale& scale,
               NearestFeature& best) noexcept;

/// The lowest triangle incident to a feature. \pre it has one
[[nodiscard]] TriangleId lowest_triangle(const Topology& topology, const Feature& feature) noexcept;

/// The answer once the feature is known. \pre it counts for p, and a triangle has it
[[nodiscard]] ClosestFeature describe_closest(const TriangleMesh& mesh, const Topology& topology,
                                              const NearestFeature& nearest, const Vec3& p,
                                              const RowScale& scale) noexcept;

} // namespace proxima
