#include "query/closest/brute_force.h"

#include "base/check.h"
#include "query/closest/feature_distance.h"

namespace proxima {

ClosestFeature closest_feature_by_brute_force(const TriangleMesh& mesh, const Topology& topology,
                                              const Vec3& p) noexcept
{
    PROXIMA_CHECK_GT(mesh.triangle_count(), 0U);
    if (!p.allFinite()) return no_closest_feature();
    const RowScale scale = row_scale_of(mesh);
    const auto is_used = [&](std::uint32_t id) {
        return !topology.triangles(VertexId{id}).empty();
    };
    NearestFeature best;
    const double distance = ((p - bounding_box(mesh).center()) * scale.up).cwiseAbs().maxCoeff();
    if (!(distance < endless_distance)) {
        std::uint32_t first = 0;
        while (!is_used(first)) ++first;
        best.feature = {FeatureKind::vertex, first};
        return describe_closest(mesh, topology, best, p, scale);
    }
    const auto offer = [&](double squared, FeatureKind kind, std::uint32_t id) {
        const NearestFeature found = {squared, {kind, id}};
        if (squared <= best.squared && found < best) best = found;
    };
    for (std::uint32_t id = 0; id < mesh.vertex_count(); ++id) {
        if (!is_used(id)) continue;
        offer(squared_distance(mesh.position(VertexId{id}), p, scale), FeatureKind::vertex, id);
    }
    for (std::uint32_t id = 0; id < topology.edge_count(); ++id) {
        const EdgeVertices& ends = topology.vertices(EdgeId{id});
        offer(foot_between(mesh.position(ends[0]), mesh.position(ends[1]), p, scale).squared,
              FeatureKind::edge, id);
    }
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id)
        offer(foot_inside(mesh.triangle(TriangleId{id}), p, scale).squared, FeatureKind::face, id);
    return describe_closest(mesh, topology, best, p, scale);
}

} // namespace proxima
