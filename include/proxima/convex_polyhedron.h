// Convex polyhedra, bounded and not: hulls, and what a Minkowski sum asks of them (thesis 3.2, 4.3.3).
//
//     auto box = convex_hull(corners);                 // 6 facets of 4 corners, not 12 triangles
//     auto wedge = convex_hull(std::array{p0, p1}, std::array{n0, n1});   // p0 p1 swept along all
//                                                                         // between n0 and n1
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
// by exact predicates on the doubles given. A polyhedron may be flat: a polygon has a facet on
// either side, a segment one edge and no facet, a point neither. What holds a whole line (a
// half-space, a slab) has no corner to start from and is refused.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

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

/// Immutable; make one by convex_hull() or the makers below. Members are noexcept, do not
/// allocate, and may be called from any thread. Indices must be in range.
class ConvexPolyhedron {
public:
    /// Dimension of its affine hull: 0 point, 1 segment or half-line, 2 polygon, 3 body.
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
    /// angle but for rounding does not count. O(points).
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

    /// The sign of a facet's outward normal . direction. Exact. \pre |direction| <= 2^302
    [[nodiscard]] int normal_sign(std::uint32_t facet,
                                  const Displacement& direction) const noexcept;

private:
    friend class PolyhedronAssembler;
    friend struct FacetSign;

    struct Facet {
        Vec3 normal;          ///< u x v, rounded
        double tolerance = 0; ///< bounds the error of normal . d per |d.x| + |d.y| + |d.z|
        std::array<std::uint32_t, 3> corners{}; ///< a, b, c with u = b - a, v = c - a; a is a point
        std::uint32_t first = 0;                ///< loop: [first, first + size)
        std::uint32_t size = 0;
    };

    int dimension_ = 0;
    std::size_t point_count_ = 0;
    std::vector<Vec3> vertices_;
    std::vector<Facet> facets_;
    std::vector<std::uint32_t> loops_;
    std::vector<PolyhedronEdge> edges_;
    std::vector<std::uint32_t> star_first_;
    std::vector<PolyhedronNeighbour> stars_;
};

/// Coordinates of a polyhedron are no larger: products of them must stay finite.
inline constexpr double max_polyhedron_coordinate = 0x1p+300;

/// The smallest convex set that holds the points and all half-lines from them along the rays. Any
/// dimension; points and rays that are not extreme are left out, the others keep their order. Exact
/// for the doubles given: facets of any number of corners, no two of them in one plane.
/// Errors: invalid_argument (no point; NaN or infinity; a ray of no length; rays that span a whole
/// line: such a set has no corner), limit_exceeded (a coordinate above max_polyhedron_coordinate,
/// or more than 2^31 vertices), cancelled. O(n log n) for n vertices in random order.
[[nodiscard]] Result<ConvexPolyhedron> convex_hull(std::span<const Vec3> points,
                                                   std::span<const Vec3> rays = {},
                                                   const Execution& execution = {});

struct ConvexMeshOptions {
    /// How far a vertex may stand beyond the plane of a triangle, per diagonal of the bounding box:
    /// coordinates of round shapes are rounded, so their faces are never quite flat. Exact
    /// predicates say whether a vertex does, and how far is rounded by up to 2^-49 of the diagonal,
    /// wherever the mesh is. With 0, none may at all.
    double tolerance = 1e-9;
    Execution execution = {};
};

/// The polyhedron that a closed convex mesh bounds: the exact hull of its vertices, once every edge
/// has two triangles, all are connected, no vertex stands beyond a triangle's plane by more than
/// the tolerance, and by area and volume it wraps the hull once. Which way the triangles are turned
/// does not matter. Errors: invalid_mesh (empty; NaN or infinity; an open or branching edge; one
/// side only; several components; all vertices in one plane; not convex), saying where;
/// limit_exceeded (coordinates beyond max_polyhedron_coordinate); cancelled. O(n log n), and O(k) more
/// for a triangle whose only corner on the hull has k neighbours there.
[[nodiscard]] Result<ConvexPolyhedron> polyhedron_of_mesh(const TriangleMesh& mesh,
                                                          const ConvexMeshOptions& options = {});

/// A triangle: of dimension 2, or less if its corners are in a line. Errors as convex_hull.
[[nodiscard]] Result<ConvexPolyhedron> polyhedron_of_triangle(const Triangle& triangle);

/// A box. Errors as convex_hull; invalid_argument for an empty one.
[[nodiscard]] Result<ConvexPolyhedron> polyhedron_of_box(const Box& box);

/// -x for all x of the polyhedron.
[[nodiscard]] ConvexPolyhedron mirrored(const ConvexPolyhedron& polyhedron);

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
                                                                 const Execution& execution = {});

} // namespace proxima
