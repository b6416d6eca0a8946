#include "minkowski/span_a_line.h"
#include "proxima/convex_polyhedron.h"

#include "minkowski/polyhedron_assembler.h"
#include "minkowski/quickhull.h"

#include <algorithm>
#include <string>
#include <vector>

namespace proxima {
namespace {

using detail::AffineSpan;
using detail::HullVertices;

Status check_coordinates(std::span<const Vec3> vectors, const char* kind)
{
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        const auto where = [&] { return kind + (' ' + std::to_string(i)); };
        if (!vectors[i].allFinite()) {
            return fail(ErrorCode::invalid_argument, "a coordinate is NaN or infinite", where());
        }
        if (vectors[i].cwiseAbs().maxCoeff() > max_polyhedron_coordinate) {
            return fail(ErrorCode::limit_exceeded,
                        "a coordinate is beyond 2^300, about 2e90: scale the shape down", where());
        }
    }
    return {};
}

Status check_input(std::span<const Vec3> points, std::span<const Vec3> rays)
{
    if (points.empty()) {
        return fail(ErrorCode::invalid_argument, "a convex hull needs at least one point");
    }
    if (points.size() + rays.size() > (std::size_t{1} << 31U)) {
        return fail(ErrorCode::limit_exceeded, "more than 2^31 points");
    }
    if (Status status = check_coordinates(points, "point"); !status) return status;
    if (Status status = check_coordinates(rays, "ray"); !status) return status;
    const auto zero = std::ranges::find_if(rays, [](const Vec3& ray) { return ray.isZero(0); });
    if (zero != rays.end()) {
        return fail(ErrorCode::invalid_argument, "a ray has no length",
                    "ray " + std::to_string(zero - rays.begin()));
    }
    return {};
}

/// The hull of vertices in a line: its two ends.
ConvexPolyhedron hull_in_line(const HullVertices& vertices, const AffineSpan& span)
{
    // The first vertex of the span is an end already: the lowest in lexicographic order, or the
    // highest where a ray goes down from a point above it.
    const std::uint32_t first = span.vertices[0];
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
        const Vec3& p = vertices.coordinates[a];
        const Vec3& q = vertices.coordinates[b];
        return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    };
    std::uint32_t last = first;
    for (std::uint32_t v = 0; v < vertices.point_count; ++v) {
        if (before(last, v)) last = v;
    }
    if (vertices.coordinates.size() == vertices.point_count) {
        std::array<std::uint32_t, 2> ends = {std::min(first, last), std::max(first, last)};
        return PolyhedronAssembler::line(vertices, ends);
    }
    const std::uint32_t ray = vertices.point_count;
    const Vec3 zero = Vec3::Zero();
    const Vec3& direction = vertices.coordinates[ray];
    const bool upward =
        std::lexicographical_compare(zero.begin(), zero.end(), direction.begin(), direction.end());
    return PolyhedronAssembler::line(vertices, std::array{upward ? first : last, ray});
}

/// The hull of vertices in a plane: the base of the pyramid that they make with a ray off it.
Result<ConvexPolyhedron> hull_in_plane(const HullVertices& vertices, const AffineSpan& span,
                                       Progress* progress)
{
    std::vector<Vec3> coordinates(vertices.coordinates.begin(), vertices.coordinates.end());
    coordinates.emplace_back(Vec3::UnitX());
    const auto apex = static_cast<std::uint32_t>(vertices.coordinates.size());
    const HullVertices with_apex = {coordinates, vertices.point_count};
    AffineSpan solid = {3, {span.vertices[0], span.vertices[1], span.vertices[2], apex}};
    for (int axis = 0; axis < 3; ++axis) {
        coordinates.back() = Vec3::Unit(axis);
        if (detail::hull_side(with_apex, {span.vertices[0], span.vertices[1], span.vertices[2]},
                              apex) != 0)
            break;
    }
    const auto triangles = detail::quickhull(with_apex, solid, progress);
    if (!triangles) return tl::unexpected(triangles.error());
    return PolyhedronAssembler::polygon(
        vertices, PolyhedronAssembler::base_of_pyramid(with_apex, *triangles, apex));
}

Result<ConvexPolyhedron> hull_of_pointed(const HullVertices& vertices, Progress* progress)
{
    const AffineSpan span = detail::affine_span(vertices);
    if (span.dimension == 0) {
        return PolyhedronAssembler::line(vertices, std::span(span.vertices).first(1));
    }
    if (span.dimension == 1) return hull_in_line(vertices, span);
    if (span.dimension == 2) return hull_in_plane(vertices, span, progress);
    const auto triangles = detail::quickhull(vertices, span, progress);
    if (!triangles) return tl::unexpected(triangles.error());
    return PolyhedronAssembler::body(vertices, *triangles);
}

} // namespace

bool span_a_line(std::span<const Vec3> rays)
{
    if (rays.size() < 2) return false;
    // The rays span a line where the origin is not a corner of the hull of origin and rays.
    std::vector<Vec3> ends = {Vec3::Zero()};
    ends.insert(ends.end(), rays.begin(), rays.end());
    const auto hull = hull_of_pointed({ends, static_cast<std::uint32_t>(ends.size())}, nullptr);
    return std::ranges::none_of(hull->points(), [](const Vec3& p) { return p.isZero(0); });
}

Result<ConvexPolyhedron> convex_hull(std::span<const Vec3> points, std::span<const Vec3> rays,
                                     const Execution& execution)
{
    if (Status status = check_input(points, rays); !status) return tl::unexpected(status.error());
    if (span_a_line(rays)) {
        return fail(ErrorCode::invalid_argument,
                    "the rays span a whole line, so the set has no corner: leave out rays, or cut "
                    "it off");
    }
    std::vector<Vec3> coordinates(points.begin(), points.end());
    coordinates.insert(coordinates.end(), rays.begin(), rays.end());
    return hull_of_pointed({coordinates, static_cast<std::uint32_t>(points.size())},
                           execution.progress);
}

} // namespace proxima
