#include "minkowski/drawn_surface.h"

#include "geometry/length.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace proxima {
namespace {

/// Body is a ConvexPolyhedron or a MinkowskiSum; `positions` are those of its points.
template <class Body, class VertexOf>
Result<DrawnSurface> draw_facets(const Body& body, std::vector<Vec3> positions, VertexOf vertex_of,
                                 double ray_length)
{
    DrawnSurface surface;
    surface.positions = std::move(positions);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> end_of;
    for (const PolyhedronEdge& edge : body.edges()) {
        if (!body.is_ray(edge.to)) continue;
        end_of[{edge.from, edge.to}] = static_cast<std::uint32_t>(surface.positions.size());
        surface.positions.emplace_back(surface.positions[edge.from] +
                                       ray_length * unit_of(vertex_of(edge.to)));
    }
    if (!std::ranges::all_of(surface.positions, [](const Vec3& p) { return p.allFinite(); })) {
        return fail(ErrorCode::limit_exceeded,
                    "a corner lies beyond the largest double, about 1.8e308: take a smaller scale "
                    "or shorter rays");
    }
    for (std::uint32_t f = 0; f < body.facet_count(); ++f) {
        const auto loop = body.facet_loop(f);
        for (std::size_t i = 0; i < loop.size(); ++i) {
            if (!body.is_ray(loop[i])) {
                surface.corners.push_back(loop[i]);
                continue;
            }
            // A ray between two points is drawn with two ends.
            const std::uint32_t before = loop[(i + loop.size() - 1) % loop.size()];
            const std::uint32_t after = loop[(i + 1) % loop.size()];
            if (!body.is_ray(before)) surface.corners.push_back(end_of.at({before, loop[i]}));
            if (!body.is_ray(after) && after != before)
                surface.corners.push_back(end_of.at({after, loop[i]}));
        }
        surface.first.push_back(static_cast<std::uint32_t>(surface.corners.size()));
    }
    return surface;
}

Status check_ray_length(double ray_length)
{
    if (ray_length > 0 && std::isfinite(ray_length)) return {};
    return fail(ErrorCode::invalid_argument, "the length of rays must be a positive number");
}

tl::unexpected<Error> nothing_to_draw(const char* what)
{
    return fail(ErrorCode::invalid_argument, std::string(what) + " has no polygons to draw");
}

} // namespace

Result<DrawnSurface> draw(const ConvexPolyhedron& polyhedron, double ray_length)
{
    if (Status status = check_ray_length(ray_length); !status)
        return tl::unexpected(status.error());
    if (polyhedron.dimension() < 2) return nothing_to_draw("a point, a segment or a half-line");
    return draw_facets(
        polyhedron, {polyhedron.points().begin(), polyhedron.points().end()},
        [&](std::uint32_t v) { return polyhedron.vertex(v); }, ray_length);
}

Result<DrawnSurface> draw(const MinkowskiSum& sum, double ray_length)
{
    if (Status status = check_ray_length(ray_length); !status)
        return tl::unexpected(status.error());
    if (sum.is_all_of_space()) return nothing_to_draw("a sum that is all of space");
    if (sum.holds_line())
        return nothing_to_draw("a sum that holds a whole line has no corners: it");
    if (sum.dimension() < 2)
        return nothing_to_draw("a sum that is a point, a segment or a half-line");
    std::vector<Vec3> positions;
    for (std::uint32_t v = 0; v < sum.point_count(); ++v) positions.push_back(sum.position(v));
    return draw_facets(
        sum, std::move(positions), [&](std::uint32_t v) { return sum.position(v); }, ray_length);
}

Result<TriangleMesh> triangulate(const DrawnSurface& surface)
{
    std::vector<TriangleCorners> triangles;
    for (std::size_t f = 0; f < surface.polygon_count(); ++f) {
        const auto polygon = surface.polygon(f);
        for (std::size_t i = 2; i < polygon.size(); ++i)
            triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
    }
    return make_triangle_mesh(surface.positions, std::move(triangles));
}

} // namespace proxima
