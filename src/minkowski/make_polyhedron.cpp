#include "proxima/convex_polyhedron.h"

#include "base/progress.h"
#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "proxima/topology.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace proxima {
namespace {

std::string point_text(const Vec3& p)
{
    return concat("(", p.x(), ", ", p.y(), ", ", p.z(), ")");
}

/// +1 if a triangle runs from one vertex of an edge to the other, -1 if it runs back; 0 if both, for
/// it repeats a vertex.
int way_along(const TriangleCorners& corners, const EdgeVertices& edge)
{
    const auto [low, high] = edge;
    int way = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const VertexId from{corners[i]};
        const VertexId to{corners[(i + 1) % 3]};
        if (from == low && to == high) ++way;
        if (from == high && to == low) --way;
    }
    return way;
}

/// Every edge has two triangles, and all are connected across edges. Returns +1 or -1 for every
/// triangle: with those of -1 turned over, all face the same way, in or out.
Result<std::vector<int>> check_surface(const TriangleMesh& mesh, Progress* progress)
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
    std::vector<int> turns(mesh.triangle_count(), 0); // 0: not met
    std::vector<std::uint32_t> to_do = {0};
    turns[0] = 1;
    while (!to_do.empty()) {
        const std::uint32_t here = to_do.back();
        to_do.pop_back();
        for (int side = 0; side < 3; ++side) {
            const TriangleId across = topology->across(TriangleId{here}, side);
            if (across == no_triangle) continue;
            const std::uint32_t there = to_index(across);
            const EdgeId edge = topology->edges(TriangleId{here})[static_cast<std::size_t>(side)];
            const EdgeVertices& ends = topology->vertices(edge);
            const int way_here = turns[here] * way_along(mesh.triangles()[here], ends);
            const int way_there = way_along(mesh.triangles()[there], ends);
            if (turns[there] == 0) {
                turns[there] = way_here * way_there > 0 ? -1 : 1;
                to_do.push_back(there);
            } else if (way_here * turns[there] * way_there > 0) {
                return fail(ErrorCode::invalid_mesh,
                            concat("the surface has one side only, as a Moebius strip: triangles ",
                                   here, " and ", there, " at the edge from vertex ",
                                   to_index(ends[0]), " ", point_text(mesh.position(ends[0])),
                                   " to vertex ", to_index(ends[1]),
                                   " cannot both face outward with the others"));
            }
        }
    }
    const auto unmet = std::ranges::find(turns, 0);
    if (unmet != turns.end()) {
        return fail(ErrorCode::invalid_mesh,
                    concat("the mesh has several components: triangle ", unmet - turns.begin(),
                           " is not connected with triangle 0"));
    }
    return turns;
}

bool is_corner(const Triangle& triangle, const Vec3& p)
{
    return std::ranges::find(triangle.vertices, p) != triangle.vertices.end();
}

/// Finds the point of the hull that is highest above a triangle's plane, or lowest, exactly.
class Climber {
public:
    Climber(const ConvexPolyhedron& hull, int up) : hull_(hull), up_(up) {}

    /// Whether no point is higher than this vertex.
    [[nodiscard]] bool is_top(const Triangle& triangle, std::uint32_t vertex) const
    {
        return higher_neighbour(triangle, vertex) == vertex;
    }

    /// Climbs from the last one found.
    const Vec3& operator()(const Triangle& triangle)
    {
        while (true) {
            const std::uint32_t next = higher_neighbour(triangle, at_);
            if (next == at_) return hull_.vertex(at_);
            at_ = next;
        }
    }

private:
    /// The vertex itself where it has none.
    [[nodiscard]] std::uint32_t higher_neighbour(const Triangle& triangle,
                                                 std::uint32_t vertex) const
    {
        const Displacement u = {triangle[0], triangle[1]};
        const Displacement v = {triangle[0], triangle[2]};
        const Vec3& here = hull_.vertex(vertex);
        const bool is_here = is_corner(triangle, here);
        for (const PolyhedronNeighbour& next : hull_.neighbours(vertex)) {
            const Vec3& there = hull_.vertex(next.vertex);
            if (is_here && is_corner(triangle, there)) continue; // level, without arithmetic
            if (up_ * determinant_sign(u, v, Displacement{here, there}) > 0) return next.vertex;
        }
        return vertex;
    }

    const ConvexPolyhedron& hull_;
    int up_;
    std::uint32_t at_ = 0;
};

constexpr std::uint32_t no_corner = std::numeric_limits<std::uint32_t>::max();

/// The hull's vertex at every position that has one, by the order that they have in common; else
/// no_corner.
std::vector<std::uint32_t> vertices_of_hull(std::span<const Vec3> positions,
                                            const ConvexPolyhedron& hull)
{
    std::vector<std::uint32_t> vertices(positions.size(), no_corner);
    std::uint32_t next = 0;
    for (std::size_t v = 0; v < positions.size() && next < hull.vertex_count(); ++v) {
        if (positions[v] == hull.vertex(next)) vertices[v] = next++;
    }
    return vertices;
}

/// Checks that the whole hull lies on one side of every triangle's plane. Exact predicates say
/// whether it does. What stands beyond a plane is measured from the triangle's corner, so that
/// roundings are those of the mesh's size, wherever it is.
Status check_convex(const TriangleMesh& mesh, const ConvexPolyhedron& hull, double tolerance,
                    Progress* progress)
{
    StageSteps steps(progress, "holding triangles against their hull", mesh.triangle_count(), 64);
    Climber highest_above(hull, 1);
    Climber lowest_below(hull, -1);
    const std::vector<std::uint32_t> hull_vertices = vertices_of_hull(mesh.positions(), hull);
    // Returns the corner of a triangle that has the fewest neighbours on the hull, because all of a
    // corner's neighbours are looked at. The tip of a cone can have thousands.
    const auto corner_of = [&](const TriangleCorners& corners) {
        std::uint32_t best = no_corner;
        for (const std::uint32_t corner : corners) {
            const std::uint32_t vertex = hull_vertices[corner];
            if (vertex == no_corner) continue;
            if (best == no_corner || hull.neighbours(vertex).size() < hull.neighbours(best).size())
                best = vertex;
        }
        return best;
    };
    double worst = tolerance;
    std::size_t worst_triangle = 0;
    Vec3 worst_point = Vec3::Zero();
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
        if (!steps.done(1)) return cancelled("making a convex polyhedron");
        const Triangle triangle = mesh.triangle(TriangleId{static_cast<std::uint32_t>(t)});
        const Vec3 normal = unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
        if (normal.isZero(0)) continue; // of no area: its vertices are seen through others
        // Where the mesh is convex, this corner mostly shows it.
        const std::uint32_t corner = corner_of(mesh.triangles()[t]);
        if (corner != no_corner &&
            (highest_above.is_top(triangle, corner) || lowest_below.is_top(triangle, corner)))
            continue;
        const auto side_of = [&](const Vec3& p) {
            return is_corner(triangle, p) ? 0 : orient3d(triangle[0], triangle[1], triangle[2], p);
        };
        const Vec3& highest = highest_above(triangle);
        if (side_of(highest) <= 0) continue;
        const double up = normal.dot(highest - triangle[0]);
        if (up <= worst && worst > 0) continue; // whatever is below
        const Vec3& lowest = lowest_below(triangle);
        if (side_of(lowest) >= 0) continue;
        const double down = normal.dot(triangle[0] - lowest);
        // There is something on either side, though rounding may leave nothing of it.
        constexpr double least = std::numeric_limits<double>::denorm_min();
        const double beyond = std::max(std::min(up, down), least);
        if (beyond <= worst) continue;
        worst = beyond;
        worst_triangle = t;
        worst_point = up < down ? highest : lowest;
    }
    steps.finish();
    if (worst <= tolerance) return {};
    return fail(ErrorCode::invalid_mesh,
                concat("the mesh is not convex: the point ", point_text(worst_point), " stands ",
                       worst, " beyond the plane of triangle ", worst_triangle,
                       "; take its convex hull, or cut it into convex parts"));
}

/// The area of polygons, and the volume that they bound where they face outward; lengths in units
/// of `unit` and from `origin`, so that neither can vanish.
class Measure {
public:
    Measure(Vec3 origin, double unit) : origin_(std::move(origin)), unit_(unit) {}

    /// `turn` is -1 for a polygon that faces inward.
    template <class CornerOf>
    void add(std::size_t corners, CornerOf corner, int turn)
    {
        Vec3 sum = Vec3::Zero();
        for (std::size_t i = 2; i < corners; ++i) {
            const Vec3 u = (corner(i - 1) - corner(0)) / unit_;
            const Vec3 v = (corner(i) - corner(0)) / unit_;
            sum += 0.5 * u.cross(v);
        }
        area_ += sum.norm();
        volume_ += turn * sum.dot((corner(0) - origin_) / unit_) / 3;
    }

    [[nodiscard]] double area() const noexcept { return area_; }
    [[nodiscard]] double volume() const noexcept { return volume_; }

private:
    Vec3 origin_;
    double unit_;
    double area_ = 0;
    double volume_ = 0;
};

/// Counting what faces outward less what faces inward, a closed surface on its hull covers every
/// part of it equally often: once, or never where it is folded upon itself and holds no volume. One
/// that covers all and has the hull's area covers nothing twice. `turns` is check_surface's.
Status check_wrap(const TriangleMesh& mesh, const std::vector<int>& turns,
                  const ConvexPolyhedron& hull, double tolerance, double unit)
{
    Measure surface(hull.vertex(0), unit);
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
        const Triangle triangle = mesh.triangle(TriangleId{static_cast<std::uint32_t>(t)});
        surface.add(
            3, [&](std::size_t i) { return triangle.vertices[i]; }, turns[t]);
    }
    Measure whole(hull.vertex(0), unit);
    for (std::uint32_t f = 0; f < hull.facet_count(); ++f) {
        const auto loop = hull.facet_loop(f);
        whole.add(
            loop.size(), [&](std::size_t i) { return hull.vertex(loop[i]); }, 1);
    }
    constexpr double slack = 1e-6;
    if (std::abs(surface.area() - whole.area()) > slack * whole.area()) {
        return fail(ErrorCode::invalid_mesh,
                    concat("the surface does not wrap its convex hull once: its area is ",
                           surface.area() / whole.area(), " times the hull's; it may be folded"));
    }
    // What the tolerance and roundings may take from the volume of a surface that wraps the hull.
    const double missing = (tolerance + 1e-15) * surface.area();
    const double volume = std::abs(surface.volume());
    if (volume + missing >= 0.5 * whole.volume()) return {};
    return fail(ErrorCode::invalid_mesh,
                concat("the surface does not wrap its convex hull once: the volume in it is ",
                       volume / whole.volume(), " times the hull's; it may be folded"));
}

} // namespace

Result<ConvexPolyhedron> polyhedron_of_mesh(const TriangleMesh& mesh,
                                            const ConvexMeshOptions& options)
{
    const auto bounds = checked_bounding_box(mesh);
    if (!bounds) return tl::unexpected(bounds.error());
    const auto turns = check_surface(mesh, options.execution.progress);
    if (!turns) return tl::unexpected(turns.error());
    std::vector<bool> is_used(mesh.vertex_count(), false);
    for (const auto& corners : mesh.triangles()) {
        for (const std::uint32_t corner : corners) is_used[corner] = true;
    }
    std::vector<Vec3> points;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
        if (!is_used[v]) continue;
        points.push_back(mesh.positions()[v]);
        if (points.back().cwiseAbs().maxCoeff() > max_polyhedron_coordinate) {
            return fail(ErrorCode::limit_exceeded,
                        "a coordinate is beyond 2^300, about 2e90: scale the mesh down",
                        concat("vertex ", v));
        }
    }
    auto hull = convex_hull(points, {}, options.execution);
    if (!hull) return hull;
    if (hull->dimension() < 3) {
        return fail(ErrorCode::invalid_mesh,
                    "the mesh has no volume: all its vertices lie in one plane");
    }
    const double diagonal = length_of(bounds->extent());
    if (Status status =
            check_convex(mesh, *hull, options.tolerance * diagonal, options.execution.progress);
        !status)
        return tl::unexpected(status.error());
    if (Status status = check_wrap(mesh, *turns, *hull, options.tolerance, diagonal); !status)
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
