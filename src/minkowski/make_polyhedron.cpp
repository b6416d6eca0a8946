#include "proxima/convex_polyhedron.h"

#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "proxima/topology.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace proxima {
namespace {

std::string point_text(const Vec3& p)
{
    return concat("(", p.x(), ", ", p.y(), ", ", p.z(), ")");
}

/// Every edge has two triangles, and all are connected across edges.
Status check_surface(const TriangleMesh& mesh, Progress* progress)
{
    const auto topology = build_topology(mesh, {.execution = {.progress = progress}});
    if (!topology) return tl::unexpected(topology.error());
    for (std::uint32_t e = 0; e < topology->edge_count(); ++e) {
        const auto count = topology->triangles(EdgeId{e}).size();
        if (count == 2) continue;
        const auto [from, to] = topology->vertices(EdgeId{e});
        return fail(ErrorCode::invalid_mesh,
                    concat(count < 2 ? "the mesh is open" : "the surface branches", ": ", count,
                           count == 1 ? " triangle has" : " triangles have",
                           " the edge from vertex ", to_index(from), " ",
                           point_text(mesh.position(from)), " to vertex ", to_index(to),
                           ", where a convex surface has two"));
    }
    std::vector<bool> is_met(mesh.triangle_count(), false);
    std::vector<std::uint32_t> to_do = {0};
    is_met[0] = true;
    std::size_t met = 1;
    while (!to_do.empty()) {
        const TriangleId triangle{to_do.back()};
        to_do.pop_back();
        for (int side = 0; side < 3; ++side) {
            const TriangleId other = topology->across(triangle, side);
            if (other == no_triangle || is_met[to_index(other)]) continue;
            is_met[to_index(other)] = true;
            ++met;
            to_do.push_back(to_index(other));
        }
    }
    const auto unmet = std::ranges::find(is_met, false) - is_met.begin();
    if (met < mesh.triangle_count()) {
        return fail(ErrorCode::invalid_mesh, concat("the mesh has several components: triangle ",
                                                    unmet, " is not connected with triangle 0"));
    }
    return {};
}

bool is_corner(const Triangle& triangle, const Vec3& p)
{
    return std::ranges::find(triangle.vertices, p) != triangle.vertices.end();
}

/// The point of the hull that is highest above a triangle's plane, or lowest, exactly, climbing
/// from the last one found.
class Climber {
public:
    Climber(const ConvexPolyhedron& hull, int up) : hull_(hull), up_(up) {}

    const Vec3& operator()(const Triangle& triangle)
    {
        const Displacement u = {triangle[0], triangle[1]};
        const Displacement v = {triangle[0], triangle[2]};
        for (bool higher = true; higher;) {
            higher = false;
            const Vec3& here = hull_.vertex(at_);
            const bool is_here = is_corner(triangle, here);
            for (const PolyhedronNeighbour& next : hull_.neighbours(at_)) {
                const Vec3& there = hull_.vertex(next.vertex);
                if (is_here && is_corner(triangle, there)) continue; // level, without arithmetic
                if (up_ * determinant_sign(u, v, Displacement{here, there}) <= 0) continue;
                at_ = next.vertex;
                higher = true;
                break;
            }
        }
        return hull_.vertex(at_);
    }

private:
    const ConvexPolyhedron& hull_;
    int up_;
    std::uint32_t at_ = 0;
};

/// Checks that the whole hull lies on one side of every triangle's plane. Exact predicates say
/// whether it does. What stands beyond a plane is measured from the triangle's corner, so that
/// roundings are those of the mesh's size, wherever it is.
Status check_convex(const TriangleMesh& mesh, const ConvexPolyhedron& hull, double tolerance)
{
    Climber highest_above(hull, 1);
    Climber lowest_below(hull, -1);
    double worst = tolerance;
    std::size_t worst_triangle = 0;
    Vec3 worst_point = Vec3::Zero();
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
        const Triangle triangle = mesh.triangle(TriangleId{static_cast<std::uint32_t>(t)});
        const Vec3 normal = unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
        if (normal.isZero(0)) continue; // of no area: its vertices are seen through others
        const auto side_of = [&](const Vec3& p) {
            return is_corner(triangle, p) ? 0 : orient3d(triangle[0], triangle[1], triangle[2], p);
        };
        const Vec3& highest = highest_above(triangle);
        if (side_of(highest) <= 0) continue;
        const Vec3& lowest = lowest_below(triangle);
        if (side_of(lowest) >= 0) continue;
        const double up = normal.dot(highest - triangle[0]);
        const double down = normal.dot(triangle[0] - lowest);
        // There is something on either side, though rounding may leave nothing of it.
        constexpr double least = std::numeric_limits<double>::denorm_min();
        const double beyond = std::max(std::min(up, down), least);
        if (beyond <= worst) continue;
        worst = beyond;
        worst_triangle = t;
        worst_point = up < down ? highest : lowest;
    }
    if (worst <= tolerance) return {};
    return fail(ErrorCode::invalid_mesh,
                concat("the mesh is not convex: the point ", point_text(worst_point), " stands ",
                       worst, " beyond the plane of triangle ", worst_triangle,
                       "; take its convex hull, or cut it into convex parts"));
}

/// The area of a polygon or a triangle, in units of `unit` squared, so that it cannot vanish.
template <class CornerOf>
double area_of(std::size_t corners, CornerOf corner, double unit)
{
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 2; i < corners; ++i) {
        const Vec3 u = (corner(i - 1) - corner(0)) / unit;
        const Vec3 v = (corner(i) - corner(0)) / unit;
        sum += 0.5 * u.cross(v);
    }
    return sum.norm();
}

/// A surface on its hull that is as large as the hull's wraps it once. A closed one could also be
/// folded upon itself and leave a part open.
Status check_area(const TriangleMesh& mesh, const ConvexPolyhedron& hull, double unit)
{
    double mesh_area = 0;
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
        const Triangle triangle = mesh.triangle(TriangleId{static_cast<std::uint32_t>(t)});
        mesh_area += area_of(
            3, [&](std::size_t i) { return triangle.vertices[i]; }, unit);
    }
    double hull_area = 0;
    for (std::uint32_t f = 0; f < hull.facet_count(); ++f) {
        const auto loop = hull.facet_loop(f);
        hull_area += area_of(
            loop.size(), [&](std::size_t i) { return hull.vertex(loop[i]); }, unit);
    }
    constexpr double slack = 1e-6;
    if (std::abs(mesh_area - hull_area) <= slack * hull_area) return {};
    return fail(ErrorCode::invalid_mesh,
                concat("the surface does not wrap its convex hull once: its area is ",
                       mesh_area / hull_area, " times the hull's; it may be folded"));
}

} // namespace

Result<ConvexPolyhedron> polyhedron_of_mesh(const TriangleMesh& mesh,
                                            const ConvexMeshOptions& options)
{
    const auto bounds = checked_bounding_box(mesh);
    if (!bounds) return tl::unexpected(bounds.error());
    if (Status status = check_surface(mesh, options.execution.progress); !status)
        return tl::unexpected(status.error());
    std::vector<bool> is_used(mesh.vertex_count(), false);
    for (const auto& corners : mesh.triangles()) {
        for (const std::uint32_t corner : corners) is_used[corner] = true;
    }
    std::vector<Vec3> points;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
        if (is_used[v]) points.push_back(mesh.positions()[v]);
    }
    auto hull = convex_hull(points, {}, options.execution);
    if (!hull) return hull;
    if (hull->dimension() < 3) {
        return fail(ErrorCode::invalid_mesh,
                    "the mesh has no volume: all its vertices lie in one plane");
    }
    const double diagonal = length_of(bounds->extent());
    if (Status status = check_convex(mesh, *hull, options.tolerance * diagonal); !status)
        return tl::unexpected(status.error());
    if (Status status = check_area(mesh, *hull, diagonal); !status)
        return tl::unexpected(status.error());
    return hull;
}

Result<ConvexPolyhedron> polyhedron_of_triangle(const Triangle& triangle)
{
    return convex_hull(triangle.vertices);
}

Result<ConvexPolyhedron> polyhedron_of_box(const Box& box)
{
    if (box.empty()) return fail(ErrorCode::invalid_argument, "the box is empty");
    std::array<Vec3, 8> corners;
    for (std::size_t i = 0; i < 8; ++i) {
        corners[i] = {(i & 1U) != 0 ? box.upper.x() : box.lower.x(),
                      (i & 2U) != 0 ? box.upper.y() : box.lower.y(),
                      (i & 4U) != 0 ? box.upper.z() : box.lower.z()};
    }
    return convex_hull(corners);
}

ConvexPolyhedron mirrored(const ConvexPolyhedron& polyhedron)
{
    const auto negated = [](std::span<const Vec3> vectors) {
        std::vector<Vec3> result(vectors.begin(), vectors.end());
        for (Vec3& v : result) v = -v;
        return result;
    };
    // The hull of a hull's vertices cannot fail.
    return convex_hull(negated(polyhedron.points()), negated(polyhedron.rays())).value();
}

} // namespace proxima
