#include "proxima/convex_polyhedron.h"

#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "proxima/topology.h"

#include <algorithm>
#include <cmath>
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

/// The largest n . p over the hull's points, climbing from the last one found.
class Climber {
public:
    explicit Climber(const ConvexPolyhedron& hull) : hull_(hull) {}

    double highest(const Vec3& normal)
    {
        double height = normal.dot(hull_.vertex(at_));
        for (bool higher = true; higher;) {
            higher = false;
            for (const PolyhedronNeighbour& next : hull_.neighbours(at_)) {
                const double there = normal.dot(hull_.vertex(next.vertex));
                if (there <= height) continue;
                height = there;
                at_ = next.vertex;
                higher = true;
                break;
            }
        }
        return height;
    }
    [[nodiscard]] const Vec3& point() const { return hull_.vertex(at_); }

private:
    const ConvexPolyhedron& hull_;
    std::uint32_t at_ = 0;
};

/// Checks that the whole hull lies on one side of every triangle's plane.
Status check_convex(const TriangleMesh& mesh, const ConvexPolyhedron& hull, double tolerance)
{
    Climber above(hull);
    Climber below(hull);
    double worst = tolerance;
    std::size_t worst_triangle = 0;
    Vec3 worst_point = Vec3::Zero();
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
        const Triangle triangle = mesh.triangle(TriangleId{static_cast<std::uint32_t>(t)});
        const Vec3 normal = unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
        if (normal.isZero(0)) continue; // of no area: its vertices are seen through others
        const double offset = normal.dot(triangle[0]);
        const double up = above.highest(normal) - offset;
        const double down = offset + below.highest(-normal);
        if (std::min(up, down) <= worst) continue;
        worst = std::min(up, down);
        worst_triangle = t;
        worst_point = up < down ? above.point() : below.point();
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
