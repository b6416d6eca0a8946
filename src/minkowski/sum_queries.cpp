#include "proxima/minkowski_sum.h"

#include "base/check.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "proxima/convex_polyhedron.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

SumDisplacement from_corner(const MinkowskiSum& sum, const SumCorner& corner, const Vec3& point)
{
    return {point, sum.a().vertex(corner.a), sum.b().vertex(corner.b), sum.scale()};
}

/// The edge of A or B from which the sum's edge between two corners comes. It starts at a point.
Displacement edge_direction(const MinkowskiSum& sum, std::uint32_t from, std::uint32_t to)
{
    const SumCorner& p = sum.corner(from);
    const SumCorner& q = sum.corner(to);
    if (q.kind == SumCorner::Kind::ray_of_a) return {Vec3::Zero(), sum.a().vertex(q.a)};
    if (q.kind == SumCorner::Kind::ray_of_b) return {Vec3::Zero(), sum.b().vertex(q.b)};
    if (p.a != q.a) return {sum.a().vertex(p.a), sum.a().vertex(q.a)};
    return {sum.b().vertex(p.b), sum.b().vertex(q.b)};
}

/// Whether a point of the polygon's plane is in the polygon.
bool polygon_contains(const MinkowskiSum& sum, const Vec3& point)
{
    const auto normal = sum.normal_factors(0);
    int axis = 0;
    int up = 0;
    for (; axis < 3; ++axis) {
        up = cross_component_sign(normal.u, normal.v, axis);
        if (up != 0) break;
    }
    const auto loop = sum.facet_loop(0);
    for (std::size_t i = 0; i < loop.size(); ++i) {
        std::uint32_t from = loop[i];
        std::uint32_t to = loop[(i + 1) % loop.size()];
        if (sum.is_ray(from) && sum.is_ray(to)) continue;
        int turn = up;
        if (sum.is_ray(from)) { // it comes in along the ray
            std::swap(from, to);
            turn = -up;
        }
        const Displacement along = edge_direction(sum, from, to);
        const SumDisplacement to_point = from_corner(sum, sum.corner(from), point);
        if (turn * cross_component_sign(along, to_point, axis) < 0) return false;
    }
    return true;
}

/// Whether a point is in a sum that is a point, a segment or a half-line.
bool line_contains(const MinkowskiSum& sum, const Vec3& point)
{
    const SumDisplacement to_point = from_corner(sum, sum.corner(0), point);
    if (sum.dimension() == 0) {
        // No coordinate differs: a displacement that no unit vector has an area with is none.
        for (int axis = 0; axis < 3; ++axis) {
            const Displacement unit = {Vec3::Zero(), Vec3::Unit((axis + 1) % 3)};
            if (cross_component_sign(unit, to_point, axis) != 0) return false;
            if (cross_component_sign(unit, to_point, (axis + 2) % 3) != 0) return false;
        }
        return true;
    }
    const Displacement along = edge_direction(sum, 0, 1);
    for (int axis = 0; axis < 3; ++axis) {
        if (cross_component_sign(along, to_point, axis) != 0) return false;
    }
    // On the line: neither behind the first end nor beyond the second, by a coordinate that moves.
    for (int axis = 0; axis < 3; ++axis) {
        if (along.to[axis] == along.from[axis]) continue;
        const int ahead = along.to[axis] > along.from[axis] ? 1 : -1;
        const Displacement unit = {Vec3::Zero(), Vec3::Unit((axis + 2) % 3)};
        const auto sign_of_coordinate = [&](const SumDisplacement& d) {
            return cross_component_sign(unit, d, (axis + 1) % 3); // e_(k+2) x d along k+1 is d_k
        };
        if (ahead * sign_of_coordinate(to_point) < 0) return false;
        if (sum.is_ray(1)) return true;
        return ahead * sign_of_coordinate(from_corner(sum, sum.corner(1), point)) <= 0;
    }
    return false;
}

/// The point of the half-line or segment from p along d, up to `length` times d, nearest to x.
Vec3 nearest_on_edge(const Vec3& p, const Vec3& d, double length, const Vec3& x)
{
    const double squared = d.squaredNorm();
    const double t = squared > 0 ? d.dot(x - p) / squared : 0;
    return p + std::clamp(t, 0.0, length) * d;
}

/// A sum scaled by a power of two to about 1, so that squares of lengths neither overflow nor
/// vanish.
class ScaledSum {
public:
    ScaledSum(const MinkowskiSum& sum, const Vec3& point) : sum_(sum)
    {
        double size = point.cwiseAbs().maxCoeff();
        for (std::uint32_t v = 0; v < sum.point_count(); ++v) {
            const double reach = sum.position(v).cwiseAbs().maxCoeff();
            if (std::isfinite(reach)) size = std::max(size, reach); // a scaled sum may overflow
        }
        exponent_ = size > 0 ? std::ilogb(size) : 0;
    }

    [[nodiscard]] double down(double length) const { return std::scalbn(length, -exponent_); }
    [[nodiscard]] double up(double length) const { return std::scalbn(length, exponent_); }
    [[nodiscard]] Vec3 down(const Vec3& p) const { return {down(p.x()), down(p.y()), down(p.z())}; }
    [[nodiscard]] Vec3 up(const Vec3& p) const { return {up(p.x()), up(p.y()), up(p.z())}; }

    /// A point scaled, or a ray's direction of length 1.
    [[nodiscard]] Vec3 position(std::uint32_t vertex) const
    {
        const Vec3 p = sum_.position(vertex);
        return sum_.is_ray(vertex) ? unit_of(p) : down(p);
    }
    [[nodiscard]] HalfSpace half_space(std::uint32_t facet) const
    {
        const HalfSpace plane = sum_.half_space(facet);
        return {plane.normal, down(plane.offset)};
    }

    [[nodiscard]] Vec3 nearest_on_edge(std::uint32_t from, std::uint32_t to, const Vec3& x) const
    {
        if (sum_.is_ray(from)) std::swap(from, to);
        const Vec3 p = position(from);
        const bool is_ray = sum_.is_ray(to);
        return proxima::nearest_on_edge(p, is_ray ? position(to) : Vec3(position(to) - p),
                                        is_ray ? infinity : 1, x);
    }

    /// The point of a facet nearest to x.
    [[nodiscard]] Vec3 nearest_on_facet(std::uint32_t facet, const HalfSpace& plane,
                                        const Vec3& x) const
    {
        const Vec3 foot = x - (plane.normal.dot(x) - plane.offset) * plane.normal;
        const auto loop = sum_.facet_loop(facet);
        bool inside = true;
        Vec3 best = foot;
        double best_squared = infinity;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const std::uint32_t from = loop[i];
            const std::uint32_t to = loop[(i + 1) % loop.size()];
            if (sum_.is_ray(from) && sum_.is_ray(to)) continue;
            const Vec3 p = position(sum_.is_ray(from) ? to : from);
            const Vec3 along = sum_.is_ray(to)     ? position(to)
                               : sum_.is_ray(from) ? Vec3(-position(from))
                                                   : Vec3(position(to) - p);
            if (plane.normal.cross(along).dot(foot - p) >= 0) continue;
            inside = false;
            const Vec3 candidate = nearest_on_edge(from, to, x);
            const double squared = (candidate - x).squaredNorm();
            if (squared < best_squared) {
                best_squared = squared;
                best = candidate;
            }
        }
        return inside ? foot : best;
    }

private:
    const MinkowskiSum& sum_;
    int exponent_ = 0;
};

SurfacePoint outside_point(const Vec3& nearest, const Vec3& point, std::uint32_t facet)
{
    const Vec3 d = point - nearest;
    return {length_of(d), nearest, unit_of(d), facet};
}

} // namespace

bool contains(const MinkowskiSum& sum, const Vec3& point) noexcept
{
    if (sum.facet_count() == 0) return sum.holds_line() || line_contains(sum, point);
    for (std::uint32_t f = 0; f < sum.facet_count(); ++f) {
        const auto normal = sum.normal_factors(f);
        if (determinant_sign(normal.u, normal.v, from_corner(sum, sum.support(f), point)) > 0)
            return false;
    }
    return sum.dimension() == 3 || polygon_contains(sum, point);
}

SurfacePoint signed_distance(const MinkowskiSum& sum, const Vec3& point) noexcept
{
    PROXIMA_CHECK(!sum.holds_line());
    const ScaledSum scaled(sum, point);
    const Vec3 x = scaled.down(point);
    const auto result = [&](const SurfacePoint& found) {
        return SurfacePoint{scaled.up(found.distance), scaled.up(found.nearest), found.direction,
                            found.facet};
    };
    if (sum.dimension() == 0) return result(outside_point(scaled.position(0), x, no_facet));
    if (sum.dimension() == 1)
        return result(outside_point(scaled.nearest_on_edge(0, 1, x), x, no_facet));
    const bool is_inside = sum.dimension() == 3 && contains(sum, point);
    SurfacePoint best = {is_inside ? -infinity : infinity, x, Vec3::Zero(), no_facet};
    for (std::uint32_t f = 0; f < sum.facet_count(); ++f) {
        const HalfSpace plane = scaled.half_space(f);
        if (is_inside) {
            // A point that only rounding lifts above a plane touches it.
            const double height = plane.normal.dot(x) - plane.offset;
            const double depth = std::min(height, 0.0);
            if (depth > best.distance) best = {depth, x - height * plane.normal, plane.normal, f};
            continue;
        }
        // All facets: which ones the point sees is hidden by rounding where they are nearly
        // parallel.
        SurfacePoint there = outside_point(scaled.nearest_on_facet(f, plane, x), x, f);
        if (there.distance == 0) there.direction = plane.normal;
        if (there.distance < best.distance) best = there;
    }
    return result(best);
}

std::optional<double> directional_depth(const MinkowskiSum& sum, const Vec3& point,
                                        const Vec3& direction) noexcept
{
    PROXIMA_CHECK_EQ(sum.dimension(), 3);
    if (!contains(sum, point)) return std::nullopt;
    double depth = infinity;
    for (std::uint32_t f = 0; f < sum.facet_count(); ++f) {
        const HalfSpace plane = sum.half_space(f);
        const double speed = plane.normal.dot(direction);
        if (speed <= 8 * std::numeric_limits<double>::epsilon()) continue; // it slides along
        depth = std::min(depth, std::max(0.0, plane.offset - plane.normal.dot(point)) / speed);
    }
    return depth;
}

Result<Separation> separation(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                              const MinkowskiOptions& options)
{
    const auto sum = minkowski_sum(b, mirrored(a), options); // b - a: displacements from A to B
    if (!sum) return tl::unexpected(sum.error());
    if (sum->holds_line()) {
        return fail(ErrorCode::invalid_argument,
                    "the sum of these unbounded polyhedra holds a whole line: cut one of them off");
    }
    // The origin lies in the sum if and only if they overlap. Moving B moves the sum off the
    // origin.
    const SurfacePoint origin = signed_distance(*sum, Vec3::Zero());
    return Separation{origin.distance, -origin.direction};
}

} // namespace proxima
