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
        for (std::size_t i = 0; i < a.size(); ++i) sums[i + a.size() * j] = a[i] + b[j];
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

namespace detail {

/// The vertices most extreme along one direction, with all that rounding cannot tell from them.
template <std::size_t MaxVertices, class Scalar>
class ExtremeVertices {
public:
    ExtremeVertices(const Scalar& product, double tie_tolerance) noexcept
        : tie_tolerance_(tie_tolerance)
    {
        restart(product, 0);
    }

    void offer(const Scalar& product, int vertex) noexcept
    {
        if (product > tie_above_) {
            restart(product, vertex);
        } else if (product >= tie_below_) {
            list_[count_++] = vertex;
            if (product > offset_) raise(product, vertex);
        }
    }

    [[nodiscard]] const Scalar& offset() const noexcept { return offset_; }
    [[nodiscard]] int support() const noexcept { return support_; }
    [[nodiscard]] std::span<const int> list() const noexcept { return {list_.data(), count_}; }

private:
    void restart(const Scalar& product, int vertex) noexcept
    {
        list_[0] = vertex;
        count_ = 1;
        raise(product, vertex);
    }
    void raise(const Scalar& product, int vertex) noexcept
    {
        offset_ = product;
        support_ = vertex;
        tie_above_ = Scalar(to_double(product) + tie_tolerance_);
        tie_below_ = Scalar(to_double(product) - tie_tolerance_);
    }

    double tie_tolerance_;
    Scalar offset_;
    Scalar tie_above_;
    Scalar tie_below_;
    int support_ = 0;
    std::array<int, MaxVertices> list_;
    std::size_t count_ = 0;
};

/// Collects directions and tells when two of them are not parallel.
template <class Scalar>
class DirectionSpan {
public:
    /// True once the directions given span a plane.
    [[nodiscard]] bool add(const Vector3<Scalar>& direction) noexcept
    {
        if (is_zero(direction)) return false;
        if (!has_first_) {
            first_ = direction;
            has_first_ = true;
            return false;
        }
        return !is_zero(cross(first_, direction));
    }

private:
    [[nodiscard]] static bool is_zero(const Vector3<Scalar>& vector) noexcept
    {
        return vector.x() == Scalar(0) && vector.y() == Scalar(0) && vector.z() == Scalar(0);
    }

    Vector3<Scalar> first_ = Vector3<Scalar>::Zero();
    bool has_first_ = false;
};

/// Whether listed vertices are three or more and not collinear. Directions of A come first: where A
/// is a cube they are exact, and so is then the answer, unless products underflow.
template <class Scalar>
[[nodiscard]] bool spans_facet(const SumVertices<Scalar>& vertices,
                               std::span<const int> list) noexcept
{
    if (list.size() < 3) return false;
    const auto size_a = vertices.a.size();
    const auto index_a = [&](int k) { return static_cast<std::size_t>(k) % size_a; };
    const auto index_b = [&](int k) { return static_cast<std::size_t>(k) / size_a; };
    const std::size_t first_a = index_a(list[0]);
    const std::size_t first_b = index_b(list[0]);
    DirectionSpan<Scalar> span;
    for (const int k : list) {
        const std::size_t i = index_a(k);
        if (i != first_a && span.add(vertices.a[i] - vertices.a[first_a])) return true;
    }
    for (const int k : list) {
        const std::size_t j = index_b(k);
        if (j != first_b && span.add(vertices.b[j] - vertices.b[first_b])) return true;
    }
    return false;
}

} // namespace detail

template <class Scalar>
void form_edge_normals(std::span<const Vector3<Scalar>> edges_a,
                       std::span<const Vector3<Scalar>> edges_b,
                       std::span<CandidateNormal<Scalar>> normals) noexcept
{
    const auto plain = [](const Vector3<Scalar>& v) {
        return Vec3(to_double(v.x()), to_double(v.y()), to_double(v.z()));
    };
    std::size_t next = 0;
    for (const Vector3<Scalar>& edge_a : edges_a) {
        for (const Vector3<Scalar>& edge_b : edges_b) {
            normals[next++] = {cross(edge_a, edge_b), cross_magnitude(plain(edge_a), plain(edge_b)),
                               NormalSource::edge_pair};
        }
    }
}

template <std::size_t MaxVertices, class Scalar>
int push_planes(const SumVertices<Scalar>& vertices,
                std::span<const CandidateNormal<Scalar>> normals,
                std::span<SupportPlane<Scalar>> planes) noexcept
{
    Vec3 reach = Vec3::Zero();
    for (const Vector3<Scalar>& vertex : vertices.sums) {
        for (int axis = 0; axis < 3; ++axis) {
            const double coordinate = to_double(vertex[axis]);
            if (coordinate > reach[axis]) reach[axis] = coordinate;
            if (-coordinate > reach[axis]) reach[axis] = -coordinate;
        }
    }
    int count = 0;
    for (const CandidateNormal<Scalar>& candidate : normals) {
        if (candidate.magnitude == Vec3::Zero()) continue;
        const Vector3<Scalar>& normal = candidate.direction;
        // Each product is off by less than 8 roundings of its largest terms, two by less than 16.
        const double tie_tolerance = 32 * unit_roundoff * candidate.magnitude.dot(reach);

        const Scalar first = dot(vertices.sums[0], normal);
        detail::ExtremeVertices<MaxVertices, Scalar> maximal(first, tie_tolerance);
        detail::ExtremeVertices<MaxVertices, Scalar> minimal(-first, tie_tolerance);
        for (std::size_t j = 1; j < vertices.sums.size(); ++j) {
            const Scalar product = dot(vertices.sums[j], normal);
            maximal.offer(product, static_cast<int>(j));
            minimal.offer(-product, static_cast<int>(j));
        }
        const auto is_facet = [&](std::span<const int> list) {
            return candidate.source == NormalSource::face || detail::spans_facet(vertices, list);
        };
        if (is_facet(maximal.list())) {
            planes[static_cast<std::size_t>(count++)] = {normal, maximal.offset(),
                                                         candidate.magnitude, maximal.support()};
        }
        if (is_facet(minimal.list())) {
            planes[static_cast<std::size_t>(count++)] = {-normal, minimal.offset(),
                                                         candidate.magnitude, minimal.support()};
        }
    }
    return count;
}

} // namespace proxima
