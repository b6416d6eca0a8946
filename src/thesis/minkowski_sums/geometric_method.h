// The thesis's geometric method: the Minkowski sum of two small convex polyhedra as the planes that
// bound it, found by pushing planes of candidate normals outward over all sums of vertices
// (thesis 3.2 to 3.4).
//
//     vertices  v_k = a_i + b_j, k = i + |A| j       24 of cube (A) and triangle (B)
//     normals   faces of A, faces of B, edges of A x edges of B           1 + 3 + 9
//     pushing   every normal both ways: 26 planes; kept where three supports span a facet
//
// The pushing is the same in the plane, where lines are pushed and two supports span an edge
// (planar_sum.h).
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

#include "minkowski/scalar_vector.h"
#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

namespace proxima {

/// Half the spacing of doubles at 1: the largest relative error of one rounded operation.
inline constexpr double unit_roundoff = std::numeric_limits<double>::epsilon() / 2;

/// Normals of faces always bound the sum; those of edge pairs only where the edges' arcs meet.
enum class NormalSource : std::uint8_t { face, edge_pair };

/// Whether a plane is pushed along its normal only, or one of the opposite normal as well.
enum class PushedSides : std::uint8_t { both, outward };

/// A direction, of any length, that a facet of the sum may have.
template <class Scalar, int Dim = 3>
struct CandidateNormal {
    Vector<Scalar, Dim> direction;
    Vector<double, Dim> magnitude; ///< bounds |direction| by component, whatever cancels in it
    NormalSource source = NormalSource::face;
    PushedSides sides = PushedSides::both;
};

/// The half-space normal . x <= offset, which holds the sum and touches it at vertex v_support. In
/// the plane, a half-plane.
template <class Scalar, int Dim = 3>
struct SupportPlane {
    Vector<Scalar, Dim> normal;
    Scalar offset;
    Vector<double, Dim> magnitude;
    int support = 0;
};

/// The vertices whose hull is the sum: sums[i + |a| j] = a[i] + b[j].
template <class Scalar, int Dim = 3>
struct SumVertices {
    std::span<const Vector<Scalar, Dim>> a;
    std::span<const Vector<Scalar, Dim>> b;
    std::span<const Vector<Scalar, Dim>> sums;
};

/// A span of vectors that a call's explicit template arguments fix, so that containers convert.
template <class Scalar, int Dim>
using VectorSpan = std::type_identity_t<std::span<Vector<Scalar, Dim>>>;
template <class Scalar, int Dim>
using ConstVectorSpan = std::type_identity_t<std::span<const Vector<Scalar, Dim>>>;

/// Writes a[i] + b[j] to sums[i + |a| j]. \pre sums.size() == a.size() * b.size()
template <class Scalar, int Dim = 3>
void form_sum_vertices(ConstVectorSpan<Scalar, Dim> a, ConstVectorSpan<Scalar, Dim> b,
                       VectorSpan<Scalar, Dim> sums) noexcept
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

/// A plane where it came to rest.
template <class Scalar, int Dim = 3>
struct PushedPlane {
    std::size_t candidate = 0; ///< its normal among those given
    int sign = 1;              ///< -1: pushed the opposite way
    const Scalar& offset;
    int support = 0;               ///< the first of the vertices farthest along the normal
    std::span<const int> supports; ///< those that rounding cannot tell from it, itself included
};

/// Pushes a plane of each normal, and where asked one of its opposite, to the vertices most extreme
/// along it. Calls visit(const PushedPlane&) for each, in order; its span and reference end with
/// the call. Cost |sums| dot products per normal, no allocation. Normals of zero magnitude are left
/// out. \pre !sums.empty(), scratch.size() >= 2 * sums.size()
template <class Scalar, int Dim, class Visit>
void push_each_plane(const SumVertices<Scalar, Dim>& vertices,
                     std::span<const CandidateNormal<Scalar, Dim>> normals, std::span<int> scratch,
                     Visit&& visit) noexcept;

/// Whether the sum's vertices listed span a facet: three or more that are not collinear; in the
/// plane two that are distinct. Directions of A come first: where A is a cube they are exact, and
/// so is then the answer, unless products underflow.
template <class Scalar, int Dim>
[[nodiscard]] bool spans_facet(const SumVertices<Scalar, Dim>& vertices,
                               std::span<const int> list) noexcept;

/// Pushes planes as push_each_plane; writes those that can be facets to `planes` and returns how
/// many. Left out are only planes that in exact arithmetic are no facets: normals of zero magnitude
/// (one rounded to zero is kept: the plane holds everything), and edge pairs whose supports do not
/// span a facet. \pre sums.size() <= MaxVertices, planes.size() >= 2 * normals.size()
template <std::size_t MaxVertices, class Scalar, int Dim = 3>
int push_planes(const SumVertices<Scalar, Dim>& vertices,
                std::type_identity_t<std::span<const CandidateNormal<Scalar, Dim>>> normals,
                std::type_identity_t<std::span<SupportPlane<Scalar, Dim>>> planes) noexcept;

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

/// The vertices most extreme along one direction, with all that rounding cannot tell from them,
/// listed in the scratch given.
template <class Scalar>
class ExtremeVertices {
public:
    ExtremeVertices(const Scalar& product, double tie_tolerance, std::span<int> list) noexcept
        : tie_tolerance_(tie_tolerance), list_(list)
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
    [[nodiscard]] std::span<const int> list() const noexcept { return list_.first(count_); }

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
    std::span<int> list_;
    std::size_t count_ = 0;
};

/// The largest absolute coordinates.
template <class Scalar, int Dim>
[[nodiscard]] Vector<double, Dim> reach(std::span<const Vector<Scalar, Dim>> vectors) noexcept
{
    Vector<double, Dim> result = Vector<double, Dim>::Zero();
    for (const Vector<Scalar, Dim>& vector : vectors) {
        for (int axis = 0; axis < Dim; ++axis) {
            const double coordinate = to_double(vector[axis]);
            if (coordinate > result[axis]) result[axis] = coordinate;
            if (-coordinate > result[axis]) result[axis] = -coordinate;
        }
    }
    return result;
}

/// Collects directions and tells when they span a plane; in the plane, a line.
template <class Scalar, int Dim>
class DirectionSpan {
public:
    /// True once the directions given span what a facet spans.
    [[nodiscard]] bool add(const Vector<Scalar, Dim>& direction) noexcept
    {
        static_assert(Dim == 2 || Dim == 3);
        if (is_zero(direction)) return false;
        if constexpr (Dim == 2) {
            return true;
        } else {
            if (!has_first_) {
                first_ = direction;
                has_first_ = true;
                return false;
            }
            return !is_zero(cross(first_, direction));
        }
    }

private:
    [[nodiscard]] static bool is_zero(const Vector<Scalar, Dim>& vector) noexcept
    {
        for (int axis = 0; axis < Dim; ++axis) {
            if (!(vector[axis] == Scalar(0))) return false;
        }
        return true;
    }

    Vector<Scalar, Dim> first_ = Vector<Scalar, Dim>::Zero();
    bool has_first_ = false;
};

} // namespace detail

template <class Scalar, int Dim>
bool spans_facet(const SumVertices<Scalar, Dim>& vertices, std::span<const int> list) noexcept
{
    if (list.size() < Dim) return false;
    const auto size_a = vertices.a.size();
    const auto index_a = [&](int k) { return static_cast<std::size_t>(k) % size_a; };
    const auto index_b = [&](int k) { return static_cast<std::size_t>(k) / size_a; };
    const std::size_t first_a = index_a(list[0]);
    const std::size_t first_b = index_b(list[0]);
    detail::DirectionSpan<Scalar, Dim> span;
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

template <class Scalar, int Dim, class Visit>
void push_each_plane(const SumVertices<Scalar, Dim>& vertices,
                     std::span<const CandidateNormal<Scalar, Dim>> normals, std::span<int> scratch,
                     Visit&& visit) noexcept
{
    using Plain = Vector<double, Dim>;
    // Of the operands, not of their sums: where those cancel, what was rounded before does not.
    const Plain reach =
        detail::reach<Scalar, Dim>(vertices.a) + detail::reach<Scalar, Dim>(vertices.b);
    const std::size_t count = vertices.sums.size();
    for (std::size_t index = 0; index < normals.size(); ++index) {
        const CandidateNormal<Scalar, Dim>& candidate = normals[index];
        if (candidate.magnitude == Plain::Zero()) continue;
        const Vector<Scalar, Dim>& normal = candidate.direction;
        // Each product is off by less than 8 roundings of its largest terms, 12 if vertices are
        // rounded, so two by less than 24; what underflows is below the smallest normal number.
        const double tie_tolerance = 32 * unit_roundoff * candidate.magnitude.dot(reach) +
                                     std::numeric_limits<double>::min();

        const bool both = candidate.sides == PushedSides::both;
        const Scalar first = dot(vertices.sums[0], normal);
        using Extreme = detail::ExtremeVertices<Scalar>;
        Extreme maximal(first, tie_tolerance, scratch.first(count));
        Extreme minimal(both ? -first : first, tie_tolerance, scratch.subspan(count, count));
        for (std::size_t j = 1; j < vertices.sums.size(); ++j) {
            const Scalar product = dot(vertices.sums[j], normal);
            maximal.offer(product, static_cast<int>(j));
            if (both) minimal.offer(-product, static_cast<int>(j));
        }
        visit(PushedPlane<Scalar, Dim>{index, 1, maximal.offset(), maximal.support(),
                                       maximal.list()});
        if (both) {
            visit(PushedPlane<Scalar, Dim>{index, -1, minimal.offset(), minimal.support(),
                                           minimal.list()});
        }
    }
}

template <std::size_t MaxVertices, class Scalar, int Dim>
int push_planes(const SumVertices<Scalar, Dim>& vertices,
                std::type_identity_t<std::span<const CandidateNormal<Scalar, Dim>>> normals,
                std::type_identity_t<std::span<SupportPlane<Scalar, Dim>>> planes) noexcept
{
    std::array<int, 2 * MaxVertices> scratch;
    int count = 0;
    push_each_plane(vertices, normals, scratch, [&](const PushedPlane<Scalar, Dim>& pushed) {
        const CandidateNormal<Scalar, Dim>& candidate = normals[pushed.candidate];
        if (candidate.source != NormalSource::face && !spans_facet(vertices, pushed.supports))
            return;
        SupportPlane<Scalar, Dim>& plane = planes[static_cast<std::size_t>(count++)];
        if (pushed.sign > 0) {
            plane.normal = candidate.direction;
        } else {
            plane.normal = -candidate.direction;
        }
        plane.offset = pushed.offset;
        plane.magnitude = candidate.magnitude;
        plane.support = pushed.support;
    });
    return count;
}

} // namespace proxima
