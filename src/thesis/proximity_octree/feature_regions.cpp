#include "thesis/proximity_octree/feature_regions.h"

#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "minkowski/drawn_surface.h"
#include "thesis/proximity_octree/convex_surface.h"
#include "thesis/proximity_octree/unbounded_sum.h"
#include "thesis/proximity_octree/voronoi_region.h"

#include <algorithm>
#include <vector>

namespace proxima {
namespace {

tl::unexpected<Error> no_such_feature(const char* kind, std::uint32_t id, std::size_t count)
{
    return fail(ErrorCode::invalid_argument,
                concat("there is no ", kind, " ", id, ": the mesh has ", count));
}

/// The outward normal of a triangle that has one.
Result<Vec3> normal_of(const TriangleMesh& mesh, TriangleId id)
{
    const Triangle triangle = mesh.triangle(id);
    if (is_degenerate(triangle)) {
        return fail(ErrorCode::invalid_mesh,
                    concat("triangle ", to_index(id), " has no area, so it has no normal"));
    }
    return unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
}

/// The normals of an edge's two faces, which do not bend inward.
Result<std::vector<Vec3>> normals_of_edge(const TriangleMesh& mesh, const Topology& topology,
                                          EdgeId edge)
{
    const auto sides = topology.triangles(edge);
    if (sides.size() != 2) {
        return fail(ErrorCode::invalid_mesh, concat("edge ", to_index(edge), " has ", sides.size(),
                                                    " triangles: that of a closed mesh has two"));
    }
    const auto one = normal_of(mesh, sides[0]);
    if (!one) return tl::unexpected(one.error());
    const auto other = normal_of(mesh, sides[1]);
    if (!other) return tl::unexpected(other.error());
    const auto stands_beyond = [&](const Triangle& triangle, const Vec3& point) {
        return orient3d(triangle[0], triangle[1], triangle[2], point) > 0;
    };
    const Triangle first = mesh.triangle(sides[0]);
    const bool bends_inward =
        std::ranges::any_of(mesh.triangle(sides[1]).vertices,
                            [&](const Vec3& corner) { return stands_beyond(first, corner); });
    if (bends_inward && sine_between(*one, *other) > ConvexSurfaceOptions{}.flat_sine) {
        return fail(ErrorCode::invalid_mesh,
                    concat("the mesh is not convex: it bends inward at edge ", to_index(edge)));
    }
    return std::vector{*one, *other};
}

Result<ConvexPolyhedron> region_of_edge(const TriangleMesh& mesh, const Topology& topology,
                                        EdgeId edge)
{
    const auto normals = normals_of_edge(mesh, topology, edge);
    if (!normals) return tl::unexpected(normals.error());
    const auto [p, q] = topology.vertices(edge);
    return voronoi_region_of_edge(mesh.position(p), mesh.position(q), (*normals)[0], (*normals)[1]);
}

Result<ConvexPolyhedron> region_of_vertex(const TriangleMesh& mesh, const Topology& topology,
                                          VertexId vertex)
{
    if (topology.triangles(vertex).empty()) {
        return fail(
            ErrorCode::invalid_argument,
            concat("no triangle uses vertex ", to_index(vertex), ": it is not on the surface"));
    }
    for (const EdgeId edge : topology.edges(vertex)) {
        const auto sound = normals_of_edge(mesh, topology, edge);
        if (!sound) return tl::unexpected(sound.error());
    }
    std::vector<Vec3> normals;
    for (const TriangleId triangle : topology.triangles(vertex)) {
        const auto normal = normal_of(mesh, triangle);
        if (!normal) return tl::unexpected(normal.error());
        normals.push_back(*normal);
    }
    return voronoi_region_of_vertex(mesh.position(vertex), normals);
}

} // namespace

Result<ConvexPolyhedron> voronoi_region_of(const TriangleMesh& mesh, const Topology& topology,
                                           Feature feature)
{
    switch (feature.kind) {
    case FeatureKind::vertex:
        if (feature.id >= mesh.vertex_count())
            return no_such_feature("vertex", feature.id, mesh.vertex_count());
        return region_of_vertex(mesh, topology, VertexId{feature.id});
    case FeatureKind::edge:
        if (feature.id >= topology.edge_count())
            return no_such_feature("edge", feature.id, topology.edge_count());
        return region_of_edge(mesh, topology, EdgeId{feature.id});
    case FeatureKind::face:
        break;
    }
    if (feature.id >= mesh.triangle_count())
        return no_such_feature("face", feature.id, mesh.triangle_count());
    const auto normal = normal_of(mesh, TriangleId{feature.id});
    if (!normal) return tl::unexpected(normal.error());
    return voronoi_region_of_face(mesh.triangle(TriangleId{feature.id}));
}

Result<TriangleMesh> voronoi_region_mesh(const TriangleMesh& mesh, const Topology& topology,
                                         Feature feature, double length, RegionEnd end)
{
    auto region = voronoi_region_of(mesh, topology, feature);
    if (!region) return tl::unexpected(region.error());
    if (end == RegionEnd::closed) {
        region = cut_rays(*region, length);
        if (!region) return tl::unexpected(region.error());
    }
    const auto surface = draw(*region, length);
    if (!surface) return tl::unexpected(surface.error());
    return triangulate(*surface);
}

} // namespace proxima
