// Which features of the mesh the builder's local features are: it does not keep their ids.
#pragma once

#include "geometry/exact_predicates.h"
#include "index/lists/local_features.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace proxima::testing {

inline std::uint32_t longest_side(const TriangleMesh& mesh, const Topology& topology, TriangleId id)
{
    const Triangle triangle = mesh.triangle(id);
    std::size_t longest = 0;
    double most = 0;
    for (std::size_t side = 0; side < 3; ++side) {
        const double squared =
            (triangle.vertices[(side + 1) % 3] - triangle.vertices[side]).squaredNorm();
        if (squared > most) most = squared, longest = side;
    }
    return to_index(topology.edges(id)[longest]);
}

/// By place among the local features, in their order: of each triangle the face or, of a sliver, its
/// longest side, its edges, its vertices, where they come first.
inline std::vector<Feature> names_of(const LocalFeatures& features, const TriangleMesh& mesh,
                                     const Topology& topology, std::span<const TriangleId> order)
{
    std::vector<Feature> names;
    std::vector<bool> edge_seen(topology.edge_count());
    std::vector<bool> vertex_seen(topology.vertex_count());
    const auto add = [&](FeatureKind kind, std::uint32_t id) {
        if (names.size() >= features.features.size() ||
            features.features[names.size()].kind != kind)
            throw std::logic_error("local features are in another order");
        names.push_back({kind, id});
    };
    for (std::uint32_t rank = 0; rank < order.size(); ++rank) {
        if (names.size() < features.features.size()) {
            const LocalFeature& next = features.features[names.size()];
            if (next.kind == FeatureKind::face && features.triangles(next).front() == rank) {
                add(FeatureKind::face, to_index(order[rank]));
            } else if (!is_degenerate(
                           mesh.triangle(order[rank]))) { // a sliver, as its longest side
                add(FeatureKind::edge, longest_side(mesh, topology, order[rank]));
            }
        }
        for (const EdgeId edge : topology.edges(order[rank])) {
            if (edge == no_edge || edge_seen[to_index(edge)]) continue;
            edge_seen[to_index(edge)] = true;
            add(FeatureKind::edge, to_index(edge));
        }
        for (const std::uint32_t vertex : mesh.triangles()[to_index(order[rank])]) {
            if (vertex_seen[vertex]) continue;
            vertex_seen[vertex] = true;
            add(FeatureKind::vertex, vertex);
        }
    }
    if (names.size() != features.features.size())
        throw std::logic_error("there are more local features than features");
    return names;
}

} // namespace proxima::testing
