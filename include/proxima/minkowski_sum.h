// The Minkowski sum of two convex polyhedra, bounded or not (thesis 3.1, 3.2, 4.3.3).
//
//     auto sum = minkowski_sum(a, b);              // all a + b: where B's origin may be when the
//     sum->facet_count();                          // mirrored B touches A
//     const MinkowskiSum half = sum->scaled(0.5);  // A (+) B/2: same facets, nothing computed
//
// Corners are pairs: point i of A and point j of B, a_i + lambda b_j for a scale lambda of B, and
// facets rest on such pairs: the thesis's index tracking (3.5), which holds for every pair of
// convex polyhedra as long as neither is turned.
//
// With the mirrored B, A (+) (-B) answers for the pair: B moved by t overlaps A exactly if t is in
// it, the distance of t from it is the distance of the two, and the depth of t in it is how far B
// must move to be free.
#pragma once

#include "proxima/convex_polyhedron.h"
#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace PROXIMA_EXPORT proxima {

/// Where a facet's normal comes from: a facet of A, of B, of both, or an edge of A swept along one
/// of B.
enum class FacetOrigin : std::uint8_t { a, b, both, swept };

/// A facet's source. a and b number facets of A and B by origin, edges where it is swept.
struct SumFacet {
    FacetOrigin origin = FacetOrigin::a;
    std::int8_t turn = 1; ///< swept: the normal is turn (edge of A x edge of B)
    std::uint32_t a = no_facet;
    std::uint32_t b = no_facet;
};

/// A corner of a sum's facet: a point of A and one of B, or a ray of either.
struct SumCorner {
    enum class Kind : std::uint8_t { point, ray_of_a, ray_of_b };

    Kind kind = Kind::point;
    std::uint32_t a = 0; ///< vertex of A; 0 for a ray of B
    std::uint32_t b = 0; ///< vertex of B; 0 for a ray of A
};

/// An edge of the sum, as those of ConvexPolyhedron.
using SumEdge = PolyhedronEdge;

/// Immutable and cheap to copy: copies and scaled ones share what they hold. Members do not
/// allocate and may be called from any thread. Indices must be in range.
class MinkowskiSum {
public:
    /// The scale of B.
    [[nodiscard]] double scale() const noexcept { return scale_; }

    /// A (+) lambda B for another lambda, in constant time. \pre lambda > 0, finite
    [[nodiscard]] MinkowskiSum scaled(double lambda) const noexcept;

    [[nodiscard]] const ConvexPolyhedron& a() const noexcept { return parts_->a; }
    [[nodiscard]] const ConvexPolyhedron& b() const noexcept { return parts_->b; }

    /// Dimension of its affine hull, 0 to 3.
    [[nodiscard]] int dimension() const noexcept { return parts_->dimension; }

    /// Whether the sum is everything: then it has no facets and no corners.
    [[nodiscard]] bool is_all_of_space() const noexcept
    {
        return parts_->holds_line && parts_->facets.empty();
    }
    /// Whether it holds a whole line, as a half-space does: then it has facets but no corners.
    [[nodiscard]] bool holds_line() const noexcept { return parts_->holds_line; }
    [[nodiscard]] bool is_bounded() const noexcept { return a().is_bounded() && b().is_bounded(); }

    /// Corners that are points; vertices from here on are rays.
    [[nodiscard]] std::size_t point_count() const noexcept { return parts_->point_count; }
    [[nodiscard]] std::size_t vertex_count() const noexcept { return parts_->corners.size(); }
    [[nodiscard]] bool is_ray(std::uint32_t vertex) const noexcept
    {
        return vertex >= parts_->point_count;
    }
    /// What a vertex is made of.
    [[nodiscard]] const SumCorner& corner(std::uint32_t vertex) const noexcept
    {
        return parts_->corners[vertex];
    }
    /// a_i + lambda b_j, rounded, of a point; the direction of a ray.
    [[nodiscard]] Vec3 position(std::uint32_t vertex) const noexcept;

    [[nodiscard]] std::size_t facet_count() const noexcept { return parts_->facets.size(); }
    [[nodiscard]] const SumFacet& facet(std::uint32_t facet) const noexcept
    {
        return parts_->facets[facet];
    }
    /// The facet's vertices, counter-clockwise seen from outside; rays stand together. Empty where
    /// the sum holds a line.
    [[nodiscard]] std::span<const std::uint32_t> facet_loop(std::uint32_t facet) const noexcept
    {
        const std::uint32_t first = parts_->loop_first[facet];
        return std::span(parts_->loops).subspan(first, parts_->loop_first[facet + 1] - first);
    }
    /// The pair that the facet rests on at every scale (thesis 3.5).
    [[nodiscard]] const SumCorner& support(std::uint32_t facet) const noexcept
    {
        return parts_->supports[facet];
    }
    /// The facet's half-space, rounded: n . x <= h_A(n) + lambda h_B(n).
    [[nodiscard]] HalfSpace half_space(std::uint32_t facet) const noexcept;

    /// The exact outward normal is u x v of these.
    [[nodiscard]] ConvexPolyhedron::NormalFactors
    normal_factors(std::uint32_t facet) const noexcept;

    /// Edges, with the facets at their sides. A segment has one without facets.
    [[nodiscard]] std::span<const SumEdge> edges() const noexcept { return parts_->edges; }

private:
    friend class SumAssembler;

    struct Parts {
        ConvexPolyhedron a;
        ConvexPolyhedron b;
        int dimension = 0;
        bool holds_line = false;
        std::size_t point_count = 0;
        std::vector<SumCorner> corners; ///< points, then rays
        std::vector<SumFacet> facets;
        std::vector<SumCorner> supports; ///< one per facet, a point
        std::vector<std::uint32_t> loop_first;
        std::vector<std::uint32_t> loops;
        std::vector<SumEdge> edges;
    };

    explicit MinkowskiSum(std::shared_ptr<const Parts> parts) : parts_(std::move(parts)) {}

    std::shared_ptr<const Parts> parts_;
    double scale_ = 1;
};

struct MinkowskiOptions {
    Execution execution = {};
};

/// The sum of A and B, found by overlaying their Gaussian maps. It has exactly the facets of the sum
/// of the polyhedra that the doubles describe, each once, parallel ones merged, in O(facets of A, B
/// and the sum) steps times the edges at a vertex (walks start where their neighbours ended; shapes
/// made for it can cost more); O(edges of A x edges of B) where one of them is a polygon or both are
/// unbounded. Unbounded ones are summed by their rays: no cut is needed. Errors: limit_exceeded (more
/// than 2^28 corners of all facets together), invalid_argument (both are unbounded and flat, and
/// their sum holds a whole line), cancelled.
[[nodiscard]] Result<MinkowskiSum> minkowski_sum(const ConvexPolyhedron& a,
                                                 const ConvexPolyhedron& b,
                                                 const MinkowskiOptions& options = {});

/// Whether the closed sum holds the point, for the doubles given: exact. O(facets). Thread safe, no
/// allocation. \pre point finite
[[nodiscard]] bool contains(const MinkowskiSum& sum, const Vec3& point) noexcept;

/// The point of the surface that is nearest to a point.
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
[[nodiscard]] Result<Separation> separation(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                            const MinkowskiOptions& options = {});

} // namespace proxima
