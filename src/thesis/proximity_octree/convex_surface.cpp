#include "thesis/proximity_octree/convex_surface.h"

#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "proxima/convex_polyhedron.h"

#include <algorithm>

namespace proxima {
namespace {

Status check_areas(const TriangleMesh& mesh)
{
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        if (!is_degenerate(mesh.triangle(TriangleId{t}))) continue;
        return fail(ErrorCode::invalid_mesh,
                    concat("triangle ", t, " has no area, so it has no normal: remove it"));
    }
    return {};
}

/// Whether a triangle runs along the edge from its lower vertex to its higher.
bool runs_upward(const TriangleMesh& mesh, TriangleId triangle, const EdgeVertices& edge)
{
    const TriangleCorners& corners = mesh.triangles()[to_index(triangle)];
    for (std::size_t i = 0; i < 3; ++i)
        if (corners[i] == to_index(edge[0])) return corners[(i + 1) % 3] == to_index(edge[1]);
    return false;
}

/// The two triangles of every edge run along it in opposite directions. \pre every edge has two
Status check_directions(const TriangleMesh& mesh, const Topology& topology)
{
    for (std::uint32_t e = 0; e < topology.edge_count(); ++e) {
        const EdgeVertices& ends = topology.vertices(EdgeId{e});
        const auto sides = topology.triangles(EdgeId{e});
        if (runs_upward(mesh, sides[0], ends) != runs_upward(mesh, sides[1], ends)) continue;
        return fail(ErrorCode::invalid_mesh,
                    concat("triangles ", to_index(sides[0]), " and ", to_index(sides[1]),
                           " are turned against each other: orient all counter-clockwise seen "
                           "from outside"));
    }
    return {};
}

/// The mean of the vertices in use.
Vec3 mean_vertex(const TriangleMesh& mesh, const Topology& topology)
{
    // Relative to one of them, so that nothing is lost far from the origin.
    const Vec3 start = mesh.triangle(TriangleId{0})[0];
    Vec3 sum = Vec3::Zero();
    double count = 0;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        if (topology.triangles(VertexId{v}).empty()) continue;
        sum += mesh.position(VertexId{v}) - start;
        count += 1;
    }
    return start + sum / count;
}

Status check_outward(const TriangleMesh& mesh, const Vec3& inner_point)
{
    std::size_t behind = 0;
    std::size_t before = 0;
    std::size_t first_failing = mesh.triangle_count();
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
        const Triangle triangle = mesh.triangle(TriangleId{static_cast<std::uint32_t>(t)});
        const int side = orient3d(triangle[0], triangle[1], triangle[2], inner_point);
        behind += side < 0 ? 1U : 0U;
        before += side > 0 ? 1U : 0U;
        if (side >= 0) first_failing = std::min(first_failing, t);
    }
    if (behind == mesh.triangle_count()) return {};
    if (before == mesh.triangle_count()) {
        return fail(ErrorCode::invalid_mesh,
                    "the mesh is inside out: its triangles are clockwise seen from outside; turn "
                    "them round");
    }
    return fail(ErrorCode::invalid_mesh,
                concat("the mesh is too flat to tell inside from outside: the mean of its vertices "
                       "is not behind the plane of triangle ",
                       first_failing));
}

/// The corner of the triangle that is not on the edge.
std::uint32_t opposite_corner(const TriangleMesh& mesh, TriangleId triangle,
                              const EdgeVertices& edge)
{
    const TriangleCorners& corners = mesh.triangles()[to_index(triangle)];
    return *std::ranges::find_if(corners, [&](std::uint32_t corner) {
        return corner != to_index(edge[0]) && corner != to_index(edge[1]);
    });
}

EdgeFold fold_of(const TriangleMesh& mesh, const Topology& topology, EdgeId edge,
                 const std::vector<Vec3>& normals, double flat_sine)
{
    const auto sides = topology.triangles(edge);
    const Vec3& one = normals[to_index(sides[0])];
    const Vec3& other = normals[to_index(sides[1])];
    if (one.dot(other) > 0 && sine_between(one, other) <= flat_sine) return EdgeFold::flat;
    const Triangle triangle = mesh.triangle(sides[0]);
    const std::uint32_t opposite = opposite_corner(mesh, sides[1], topology.vertices(edge));
    const int side =
        orient3d(triangle[0], triangle[1], triangle[2], mesh.position(VertexId{opposite}));
    return side < 0 ? EdgeFold::ridge : EdgeFold::flat;
}

} // namespace

double sine_between(const Vec3& one, const Vec3& other) noexcept
{
    return one.cross(other).norm();
}

Result<ConvexSurface> check_convex_surface(const TriangleMesh& mesh, const Topology& topology,
                                           const ConvexSurfaceOptions& options)
{
    if (const auto bounds = checked_bounding_box(mesh); !bounds)
        return tl::unexpected(bounds.error());
    if (Status status = check_areas(mesh); !status) return tl::unexpected(status.error());
    const auto hull = polyhedron_of_mesh(mesh, {options.convexity_tolerance, options.execution});
    if (!hull) return tl::unexpected(hull.error());
    if (Status status = check_directions(mesh, topology); !status)
        return tl::unexpected(status.error());

    ConvexSurface surface;
    surface.inner_point = mean_vertex(mesh, topology);
    if (Status status = check_outward(mesh, surface.inner_point); !status)
        return tl::unexpected(status.error());
    surface.normals.reserve(mesh.triangle_count());
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const Triangle triangle = mesh.triangle(TriangleId{t});
        surface.normals.push_back(
            unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]}));
    }
    surface.folds.reserve(topology.edge_count());
    for (std::uint32_t e = 0; e < topology.edge_count(); ++e) {
        surface.folds.push_back(
            fold_of(mesh, topology, EdgeId{e}, surface.normals, options.flat_sine));
    }
    return surface;
}

} // namespace proxima
