#include "haptics/tool/contact_features.h"

#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace proxima {

namespace {

/// Sine of the angle between triangles up to which an edge is flat: triangles of 10 mm are off a
/// plane by 10 nm then.
constexpr double flat_sine = 1e-6;

/// Numbers vertices by their position: the lowest id of those at one position stands for all.
std::vector<std::uint32_t> joined_vertices(std::span<const Vec3> positions)
{
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto key = [&](std::uint32_t i) {
        const Vec3& p = positions[i];
        return std::tuple(p[0], p[1], p[2]);
    };
    std::ranges::sort(order, [&](std::uint32_t i, std::uint32_t k) {
        return std::tuple(key(i), i) < std::tuple(key(k), k);
    });
    std::vector<std::uint32_t> joined(positions.size());
    for (std::size_t at = 0; at < order.size(); ++at) {
        const bool same = at > 0 && key(order[at]) == key(order[at - 1]);
        joined[order[at]] = same ? joined[order[at - 1]] : order[at];
    }
    return joined;
}

/// Whether both triangles at an edge lie in one plane, on either side of it.
bool is_flat(const TriangleMesh& mesh, const Topology& topology, EdgeId edge)
{
    const std::span<const TriangleId> sides = topology.triangles(edge);
    if (sides.size() != 2) return false;
    const Vec3 first = scaled_normal(mesh.triangle(sides[0]));
    const Vec3 second = scaled_normal(mesh.triangle(sides[1]));
    const double lengths = first.norm() * second.norm();
    return lengths > 0 && first.dot(second) > 0 &&
           first.cross(second).norm() <= flat_sine * lengths;
}

} // namespace

Result<ContactFeatures> ContactFeatures::build(const MeshIndex& index)
{
    const auto given = mesh_of(index);
    if (!given) return tl::unexpected(given.error());
    const std::vector<std::uint32_t> joined = joined_vertices(given->positions());
    std::vector<TriangleCorners> corners(given->triangles().begin(), given->triangles().end());
    for (TriangleCorners& each : corners)
        for (std::uint32_t& vertex : each) vertex = joined[vertex];
    auto mesh = make_triangle_mesh({given->positions().begin(), given->positions().end()},
                                   std::move(corners));
    if (!mesh) return tl::unexpected(mesh.error());
    const auto topology = build_topology(*mesh);
    if (!topology) return tl::unexpected(topology.error());

    ContactFeatures features;
    features.bounds_ = bounding_box(*mesh);
    features.positions_.assign(mesh->positions().begin(), mesh->positions().end());

    std::vector<std::uint8_t> flat(topology->edge_count());
    features.edge_first_.push_back(0);
    for (std::uint32_t edge = 0; edge < topology->edge_count(); ++edge) {
        const auto [low, high] = topology->vertices(EdgeId{edge});
        flat[edge] = static_cast<std::uint8_t>(is_flat(*mesh, *topology, EdgeId{edge}));
        for (const TriangleId triangle : topology->triangles(EdgeId{edge})) {
            for (const std::uint32_t vertex : mesh->triangles()[to_index(triangle)]) {
                if (vertex != to_index(low) && vertex != to_index(high))
                    features.edge_ring_.push_back(vertex);
            }
        }
        features.edge_first_.push_back(static_cast<std::uint32_t>(features.edge_ring_.size()));
    }
    std::vector<std::uint8_t> can_touch(mesh->vertex_count());
    features.vertex_first_.push_back(0);
    for (std::uint32_t vertex = 0; vertex < mesh->vertex_count(); ++vertex) {
        for (const EdgeId edge : topology->edges(VertexId{vertex})) {
            if (flat[to_index(edge)] == 0) can_touch[vertex] = 1;
            features.vertex_ring_.push_back(to_index(topology->other_end(edge, VertexId{vertex})));
        }
        if (topology->edges(VertexId{vertex}).empty()) can_touch[vertex] = 1;
        features.vertex_first_.push_back(static_cast<std::uint32_t>(features.vertex_ring_.size()));
    }
    const std::span<const TriangleId> ids = index.ids();
    features.rows_.resize(ids.size());
    for (std::size_t at = 0; at < ids.size(); ++at) {
        FeatureRow& row = features.rows_[at];
        const TriangleId id = ids[at];
        row.vertices = mesh->triangles()[to_index(id)];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = row.vertices[k];
            features.reach_ = std::max(features.reach_, mesh->position(VertexId{vertex}).norm());
            if (can_touch[vertex] != 0 && topology->triangles(VertexId{vertex}).front() == id)
                row.owned_vertices |= static_cast<std::uint8_t>(1U << k);
            const EdgeId edge = topology->edges(id)[k];
            row.edges[k] = to_index(edge);
            if (edge != no_edge && flat[to_index(edge)] == 0 &&
                topology->triangles(edge).front() == id)
                row.owned_edges |= static_cast<std::uint8_t>(1U << k);
        }
    }
    return features;
}

} // namespace proxima
