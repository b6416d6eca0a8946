// Distances of single features from a point, in one arithmetic for every search.
//
//     vertex   |p - v|^2
//     edge     counts where p's foot is strictly between the ends, taken in ascending vertex id
//     face     counts where p's foot is strictly inside, by more than rounding
//
// The feature with the least (squared distance, kind, id) is the answer of every search. Vertices
// and edges give the same bits from whichever triangle they are met, so searches that skip some
// triangles and the one that skips none agree to the last bit. No distance depends on how a
// compiler orders the terms of a sum, and none is less than the true one but for the rounding of
// the closest point.
// \pre for all: p is finite; differences of coordinates below 1e150. Farther ones are infinite.
#pragma once

#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"
#include "query/closest/closest_feature.h"

#include <limits>

namespace proxima {

/// A feature and its squared distance; none yet by default.
struct NearestFeature {
    double squared = std::numeric_limits<double>::infinity();
    Feature feature = {FeatureKind::face, index(no_triangle)};

    /// The order of answers.
    friend constexpr bool operator<(const NearestFeature& a, const NearestFeature& b) noexcept
    {
        return a.squared != b.squared ? a.squared < b.squared : a.feature < b.feature;
    }
    friend constexpr bool operator==(const NearestFeature&, const NearestFeature&) = default;
};

/// What a feature does not have that does not count.
inline constexpr double no_distance = std::numeric_limits<double>::quiet_NaN();

/// |a - b|^2, its terms summed x, y, z.
[[nodiscard]] inline double squared_distance(const Vec3& a, const Vec3& b) noexcept
{
    const double x = a.x() - b.x();
    const double y = a.y() - b.y();
    const double z = a.z() - b.z();
    return x * x + y * y + z * z;
}

[[nodiscard]] double squared_distance(const TriangleMesh& mesh, VertexId vertex,
                                      const Vec3& p) noexcept;

/// no_distance where p's foot is not strictly between the ends.
[[nodiscard]] double squared_distance(const TriangleMesh& mesh, const Topology& topology,
                                      EdgeId edge, const Vec3& p) noexcept;

/// no_distance where p's foot is not strictly inside.
[[nodiscard]] double squared_distance(const TriangleMesh& mesh, TriangleId face,
                                      const Vec3& p) noexcept;

/// Lowers `best` to the best of itself and all features of the triangle. 20 to 100 ns.
void offer_triangle(const TriangleMesh& mesh, const Topology& topology, TriangleId triangle,
                    const Vec3& p, NearestFeature& best) noexcept;

/// The lowest triangle incident to a feature. \pre it has one
[[nodiscard]] TriangleId lowest_triangle(const Topology& topology, const Feature& feature) noexcept;

/// The answer once the feature is known. \pre it counts for p, and a triangle has it
[[nodiscard]] ClosestFeature describe_closest(const TriangleMesh& mesh, const Topology& topology,
                                              const Feature& feature, const Vec3& p) noexcept;

} // namespace proxima
