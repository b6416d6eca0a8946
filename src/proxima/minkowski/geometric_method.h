// The thesis's geometric method: the Minkowski sum of two small convex polyhedra as the planes that
// bound it, found by pushing planes of candidate normals outward over all sums of vertices
// (thesis 3.2 to 3.4).
//
//     vertices  v_k = a_i + b_j, k = i + |A| j       24 of cube (A) and triangle (B)
//     normals   faces of A, faces of B, edges of A x edges of B           1 + 3 + 9
//     pushing   every normal both ways: 26 planes; kept where three supports span a facet
//
// Errata of the thesis that are put right here:
// - (3.2), (3.5): the union with V_A is left out; its points belong to the sum only if B holds 0.
// - (3.9): the indices of n_ij run over the edges, |E_A| and |E_B|, not over the normals.
// - (3.11): i and j count from 0, as i = k mod |A| and j = k div |A| need.
// - Pseudocode 3.2: v_1 is put in both lists, which there start empty.
// - Pseudocode 3.3.2 to 3.3.5: a vertex is offered to both lists; as an "else if" one that ties
//   with v_1 misses the minimal list.
// - Ties by float equality lose facets to rounding and make the sum too large (4 supports of a
//   facet seldom agree to the last bit). Here two products tie when they differ by no more than
//   rounding can make them differ, so that no facet of the exact sum is ever dropped. A plane kept
//   in excess bounds the sum too and cuts nothing off.
// - Collinearity is judged from differences within A and within B, not between rounded sums.
#pragma once

#include "proxima/geometry/shapes.h"
#include "proxima/minkowski/scalar_vector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace proxima {

/// Half the spacing of doubles at 1: the largest relative error of one rounded operation.
inline constexpr double unit_roundoff = std::numeric_limits<double>::epsilon() / 2;

/// Normals of faces always bound the sum; those of edge pairs only where the edges' arcs meet.
enum class NormalSource : std::uint8_t { face, edge_pair };

/// A direction, of any length, that a facet of the sum may have.
template <class Scalar>
struct CandidateNormal {
    Vector3<Scalar> direction;
    Vec3 magnitude; ///< bounds |direction| by component, whatever cancels in it
    NormalSource source = NormalSource::face;
};

/// The half-space normal . x <= offset, which holds the sum and touches it at vertex v_support.
template <class Scalar>
struct SupportPlane {
    Vector3<Scalar> normal;
    Scalar offset;
    Vec3 magnitude;
    int support = 0;
};

/// The vertices whose hull is the sum: sums[i + |a| j] = a[i] + b[j].
template <class Scalar>
struct SumVertices {
    std::span<const Vector3<Scalar>> a;
    std::span<const Vector3<Scalar>> b;
    std::span<const Vector3<Scalar>> sums;
};

/// Writes a[i] + b[j] to sums[i + |a| j]. \pre sums.size() == a.size() * b.size()
template <class Scalar>
void form_sum_vertices(std::span<const Vector3<Scalar>> a, std::span<const Vector3<Scalar>> b,
                       std::span<Vector3<Scalar>> sums) noexcept
{
    for (std::size_t j = 0; j < b.size(); ++j) {
        for (std::size_t i = 0; i < a.size(); ++i)
            sums[i + a.size() * j] = a[i] + b[j];
    }
}

/// Writes edges_a[i] x edges_b[j] to normals[i |edges_b| + j].
/// \pre normals.size() == edges_a.size() * edges_b.size()
template <class Scalar>
void form_edge_normals(std::span<const Vector3<Scalar>> edges_a,
                       std::span<const Vector3<Scalar>> edges_b,
                       std::span<CandidateNormal<Scalar>> normals) noexcept;

/// Pushes a plane of each normal, and one of its opposite, to the vertices most extreme along it;
/// writes those that can be facets to `planes` and returns how many. No allocation; cost
/// |sums| dot products per normal. Left out are only planes that in exact arithmetic are no facets:
/// normals of zero magnitude (one rounded to zero is kept: the plane holds everything), and edge
/// pairs with fewer than three supports or all of them collinear.
/// \pre sums.size() <= MaxVertices, planes.size() >= 2 * normals.size()
template <std::size_t MaxVertices, class Scalar>
int push_planes(const SumVertices<Scalar>& vertices,
                std::span<const CandidateNormal<Scalar>> normals,
                std::span<SupportPlane<Scalar>> planes) noexcept;

/// A triangle with the constants that its sums with cubes of all sizes share.
template <class Scalar>
struct TriangleFeatures {
    std::array<Vector3<Scalar>, 3> vertices;
    std::array<Vector3<Scalar>, 3> edges; ///< v1 - v0, v2 - v1, v0 - v2
    Vector3<Scalar> normal;               ///< edges[0] x edges[1]
    Vec3 normal_magnitude;
};

template <class Scalar>
[[nodiscard]] TriangleFeatures<Scalar> triangle_features(const Triangle& triangle) noexcept;

/// Vertex i of the cube (or box) about the origin; bit 0, 1, 2 of i set: upper in x, y, z.
template <class Scalar>
[[nodiscard]] Vector3<Scalar> cube_vertex(int index, const Vector3<Scalar>& half_size) noexcept
{
    return {(index & 1) != 0 ? half_size.x() : -half_size.x(),
            (index & 2) != 0 ? half_size.y() : -half_size.y(),
            (index & 4) != 0 ? half_size.z() : -half_size.z()};
}

/// The sum of a triangle and a cube about the origin: the centres of the cubes of that size that
/// meet the triangle. 17 planes in general position, never more than 26 (thesis 3.6.1).
template <class Scalar>
struct GeometricSum {
    static constexpr int cube_vertices = 8;
    static constexpr int max_planes = 26;

    std::array<SupportPlane<Scalar>, max_planes> storage;
    int count = 0;

    [[nodiscard]] std::span<const SupportPlane<Scalar>> planes() const noexcept
    {
        return {storage.data(), static_cast<std::size_t>(count)};
    }
};

/// The geometric method on a triangle and a cube of the given half edges, all positive.
/// Instantiated for double and Counted; 312 dot products, no allocation.
template <class Scalar>
[[nodiscard]] GeometricSum<Scalar> geometric_sum(const TriangleFeatures<Scalar>& triangle,
                                                 const Vector3<Scalar>& half_size) noexcept;

} // namespace proxima
