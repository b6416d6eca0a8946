// Convex polyhedra, bounded and not, with everything a Minkowski sum asks of them (thesis 3.2,
// 4.3.3).
//
//     points   p0 p1 ... p(m-1)            the corners; at least one
//     rays     r0 r1 ...                   directions in which it goes on forever; none if bounded
//     vertices 0 .. m-1 are the points, m, m+1, ... the rays: corners at infinity
//
//     facet    a half-space and the loop of its vertices, counter-clockwise seen from outside:
//              (p0 p1 r0) is the strip between two parallel half-lines
//     edge     from a point to a point or a ray, between the facets to its left and right
//
// Every point and ray is extreme, every facet is a whole one (coplanar pieces are merged), decided
// by exact predicates on the doubles given. It may be flat: a polygon has a facet on either side,
// a segment one edge and no facet, a point neither. What holds a whole line (a half-space, a slab)
// has no corner to start from and is refused.
#pragma once

#include "geometry/exact_predicates.h"
#include "geometry/shapes.h"
#include "geometry/vec.h"
#include "minkowski/scalar_vector.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace proxima {

/// The closed half-space normal . x <= offset.
struct HalfSpace {
    Vec3 normal; ///< outward, of length 1
    double offset = 0;
};

/// The side of an edge that has no facet: a segment's.
inline constexpr std::uint32_t no_facet = std::numeric_limits<std::uint32_t>::max();

/// `from` is a point; `to` a point, or a ray where the edge never ends. The left facet's loop runs
/// from -> to.
struct PolyhedronEdge {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::uint32_t left = no_facet;
    std::uint32_t right = no_facet;
};

/// A vertex's neighbour: the vertex at the other end of an edge, and the edge.
struct PolyhedronNeighbour {
    std::uint32_t vertex = 0;
    std::uint32_t edge = 0;
};

/// How far a polyhedron reaches in a direction: max n . x, infinity along a ray, and a point there.
struct PolyhedronSupport {
    double value = 0;
    std::uint32_t vertex = 0; ///< one of the points that reach farthest, rays left aside
};

/// Immutable; make one by convex_hull.h or make_polyhedron.h. Members are noexcept, do not
/// allocate, and may be called from any thread. Indices must be in range.
class ConvexPolyhedron {
public:
    /// Of its affine hull: 0 point, 1 segment or half-line, 2 polygon, 3 body.
    [[nodiscard]] int dimension() const noexcept { return dimension_; }
    [[nodiscard]] bool is_bounded() const noexcept { return point_count_ == vertices_.size(); }

    [[nodiscard]] std::span<const Vec3> points() const noexcept
    {
        return std::span(vertices_).first(point_count_);
    }
    [[nodiscard]] std::span<const Vec3> rays() const noexcept
    {
        return std::span(vertices_).subspan(point_count_);
    }
    [[nodiscard]] std::size_t vertex_count() const noexcept { return vertices_.size(); }
    [[nodiscard]] bool is_ray(std::uint32_t vertex) const noexcept
    {
        return vertex >= point_count_;
    }
    /// A point's position or a ray's direction.
    [[nodiscard]] const Vec3& vertex(std::uint32_t vertex) const noexcept
    {
        return vertices_[vertex];
    }

    [[nodiscard]] std::size_t facet_count() const noexcept { return facets_.size(); }
    /// The vertices of a facet, counter-clockwise seen from outside; rays stand together.
    [[nodiscard]] std::span<const std::uint32_t> facet_loop(std::uint32_t facet) const noexcept
    {
        return std::span(loops_).subspan(facets_[facet].first, facets_[facet].size);
    }
    /// The facet's half-space, rounded.
    [[nodiscard]] HalfSpace half_space(std::uint32_t facet) const noexcept;

    [[nodiscard]] std::span<const PolyhedronEdge> edges() const noexcept { return edges_; }
    /// Neighbours of a point, rays among them; in no particular order. Of a ray: the points.
    [[nodiscard]] std::span<const PolyhedronNeighbour>
    neighbours(std::uint32_t vertex) const noexcept
    {
        return std::span(stars_).subspan(star_first_[vertex],
                                         star_first_[vertex + 1] - star_first_[vertex]);
    }

    /// h(n) = max n . x over the polyhedron, rounded; a ray that the direction meets at a right
    /// angle but for rounding does not count. O(points); gaussian_map.h climbs faster, and exactly.
    [[nodiscard]] PolyhedronSupport support(const Vec3& direction) const noexcept;

    /// An edge's direction, exactly; of a ray's edge, the ray.
    [[nodiscard]] Displacement direction(const PolyhedronEdge& edge) const noexcept
    {
        return is_ray(edge.to) ? Displacement{Vec3::Zero(), vertices_[edge.to]}
                               : Displacement{vertices_[edge.from], vertices_[edge.to]};
    }

    /// The exact outward normal of a facet is u x v of these.
    struct NormalFactors {
        Displacement u;
        Displacement v;
    };
    [[nodiscard]] NormalFactors normal_factors(std::uint32_t facet) const noexcept;

    /// The outward normal u x v rounded, of the length that comes.
    [[nodiscard]] const Vec3& scaled_normal(std::uint32_t facet) const noexcept
    {
        return facets_[facet].normal;
    }

    /// The sign of a facet's outward normal . direction. Exact. Scalar is double, or one that
    /// counts what the filter does (operation_counts.h). \pre |direction| <= 2^302
    template <class Scalar = double>
    [[nodiscard]] int normal_sign(std::uint32_t facet, const Displacement& direction) const noexcept
    {
        using std::abs;
        // Where this filter fails, exact numbers decide.
        const Facet& plane = facets_[facet];
        const Vector3<Scalar> d =
            to_scalar<Scalar>(direction.to) - to_scalar<Scalar>(direction.from);
        const Scalar value = dot(to_scalar<Scalar>(plane.normal), d);
        const Scalar error = Scalar(plane.tolerance) * (abs(d.x()) + abs(d.y()) + abs(d.z())) +
                             Scalar(underflow_slack);
        if (value > error) return 1;
        if (value < -error) return -1;
        return exact_normal_sign(facet, direction);
    }

private:
    friend class PolyhedronAssembler;

    /// More than the three products of a normal and a direction lose by underflow, 2^-1075 each.
    static constexpr double underflow_slack = std::numeric_limits<double>::min();

    struct Facet {
        Vec3 normal;          ///< u x v, rounded
        double tolerance = 0; ///< bounds the error of normal . d per |d.x| + |d.y| + |d.z|
        std::array<std::uint32_t, 3> corners{}; ///< a, b, c with u = b - a, v = c - a; a is a point
        std::uint32_t first = 0;                ///< loop: [first, first + size)
        std::uint32_t size = 0;
    };

    [[nodiscard]] int exact_normal_sign(std::uint32_t facet,
                                        const Displacement& direction) const noexcept;

    int dimension_ = 0;
    std::size_t point_count_ = 0;
    std::vector<Vec3> vertices_;
    std::vector<Facet> facets_;
    std::vector<std::uint32_t> loops_;
    std::vector<PolyhedronEdge> edges_;
    std::vector<std::uint32_t> star_first_;
    std::vector<PolyhedronNeighbour> stars_;
};

} // namespace proxima
