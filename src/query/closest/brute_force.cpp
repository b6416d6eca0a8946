#include "query/closest/brute_force.h"

#include "base/check.h"
#include "query/closest/feature_distance.h"

namespace proxima {

ClosestFeature closest_feature_by_brute_force(const TriangleMesh& mesh, const Topology& topology,
                                              const Vec3& p) noexcept
{
    PROXIMA_CHECK_GT(mesh.triangle_count(), 0U);
    if (!p.allFinite()) return no_closest_feature();
    NearestFeature best;
    const auto offer = [&](double squared, FeatureKind kind, std::uint32_t id) {
        const NearestFeature found = {squared, {kind, id}};
        if (squared <= best.squared && found < best) best = found;
    };
    for (std::uint32_t id = 0; id < mesh.vertex_count(); ++id) {
        if (topology.triangles(VertexId{id}).empty()) continue;
        offer(squared_distance(mesh, VertexId{id}, p), FeatureKind::vertex, id);
    }
    for (std::uint32_t id = 0; id < topology.edge_count(); ++id) {
        offer(squared_distance(mesh, topology, EdgeId{id}, p), FeatureKind::edge, id);
    }
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        offer(squared_distance(mesh, TriangleId{id}, p), FeatureKind::face, id);
    }
    return describe_closest(mesh, topology, best.feature, p);
}

} // namespace proxima
