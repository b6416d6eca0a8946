#include "proxima/mesh/surface_parts.h"

#include "proxima/base/disjoint_sets.h"

#include <algorithm>
#include <cmath>

namespace proxima::detail {

namespace {

// Calls visit(a, b, edge) so that the chain of its pairs connects all proper triangles of an edge.
template <class Visit>
void for_neighbours(const TriangleMesh& mesh, const Topology& topology, const Visit& visit)
{
    for (std::uint32_t id = 0; id < topology.edge_count(); ++id) {
        TriangleId previous = no_triangle;
        for (const TriangleId triangle : topology.triangles(EdgeId{id})) {
            if (!is_proper(mesh.triangles()[index(triangle)])) continue;
            if (previous != no_triangle) visit(previous, triangle, EdgeId{id});
            previous = triangle;
        }
    }
}

void add_volume(SurfaceComponent& component, const Triangle& triangle, const Vec3& center,
                double scale) noexcept
{
    const Vec3 a = (triangle[0] - center) * scale;
    const Vec3 b = (triangle[1] - center) * scale;
    const Vec3 c = (triangle[2] - center) * scale;
    const double term = a.dot(b.cross(c)) / 6.0;
    component.volume += term;
    component.magnitude += std::abs(term);
}

} // namespace

bool is_proper(const TriangleCorners& corners) noexcept
{
    const auto [a, b, c] = corners;
    return a != b && b != c && c != a;
}

bool is_finite(const Triangle& triangle) noexcept
{
    return triangle[0].allFinite() && triangle[1].allFinite() && triangle[2].allFinite();
}

EdgeUse edge_use(const TriangleMesh& mesh, const Topology& topology, EdgeId edge) noexcept
{
    EdgeUse use;
    for (const TriangleId triangle : topology.triangles(edge)) {
        const TriangleCorners& corners = mesh.triangles()[index(triangle)];
        if (!is_proper(corners)) continue;
        const auto& sides = topology.edges(triangle);
        const auto side = std::find(sides.begin(), sides.end(), edge) - sides.begin();
        const bool forward =
            corners[static_cast<std::size_t>(side)] == index(topology.vertices(edge)[0]);
        ++(forward ? use.forward : use.backward);
    }
    return use;
}

std::uint64_t boundary_loops(const TriangleMesh& mesh, const Topology& topology)
{
    const auto vertices = static_cast<std::uint32_t>(mesh.vertex_count());
    DisjointSets loops(vertices);
    std::vector<bool> on_boundary(vertices, false);
    for (std::uint32_t id = 0; id < topology.edge_count(); ++id) {
        if (edge_use(mesh, topology, EdgeId{id}).total() != 1) continue;
        const auto [low, high] = topology.vertices(EdgeId{id});
        loops.unite(index(low), index(high));
        on_boundary[index(low)] = on_boundary[index(high)] = true;
    }
    std::uint64_t count = 0;
    for (std::uint32_t vertex = 0; vertex < vertices; ++vertex) {
        if (on_boundary[vertex] && loops.find(vertex) == vertex) ++count;
    }
    return count;
}

std::vector<std::uint8_t> fan_counts(const TriangleMesh& mesh, const Topology& topology)
{
    const auto corner = [&](TriangleId triangle, VertexId vertex) {
        const TriangleCorners& corners = mesh.triangles()[index(triangle)];
        const auto place = std::find(corners.begin(), corners.end(), index(vertex));
        return 3 * index(triangle) + static_cast<std::uint32_t>(place - corners.begin());
    };
    DisjointSets fans(static_cast<std::uint32_t>(3 * mesh.triangle_count()));
    for_neighbours(mesh, topology, [&](TriangleId a, TriangleId b, EdgeId edge) {
        for (const VertexId end : topology.vertices(edge)) {
            fans.unite(corner(a, end), corner(b, end));
        }
    });
    std::vector<std::uint8_t> counts(mesh.vertex_count(), 0);
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const TriangleCorners& corners = mesh.triangles()[id];
        if (!is_proper(corners)) continue;
        for (std::uint32_t k = 0; k < 3; ++k) {
            std::uint8_t& count = counts[corners[k]];
            if (fans.find(3 * id + k) == 3 * id + k && count < 2) ++count;
        }
    }
    return counts;
}

std::vector<SurfaceComponent> surface_components(const TriangleMesh& mesh, const Topology& topology,
                                                 const Box& bounds)
{
    const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
    DisjointSets sets(count);
    for_neighbours(mesh, topology,
                   [&](TriangleId a, TriangleId b, EdgeId) { sets.unite(index(a), index(b)); });

    std::vector<SurfaceComponent> components;
    std::vector<std::uint32_t> number(count, 0);
    const Vec3 center = bounds.empty() ? Vec3(Vec3::Zero()) : bounds.center();
    const double extent = bounds.empty() ? 0.0 : bounds.extent().maxCoeff();
    const double scale = extent > 0.0 ? 1.0 / extent : 1.0;
    for (std::uint32_t id = 0; id < count; ++id) {
        if (!is_proper(mesh.triangles()[id])) continue;
        const std::uint32_t root = sets.find(id); // the lowest id: its number is known
        if (root == id) {
            number[id] = static_cast<std::uint32_t>(components.size());
            components.push_back({.first_triangle = id});
        }
        number[id] = number[root];
        const Triangle triangle = mesh.triangle(TriangleId{id});
        if (is_finite(triangle)) {
            add_volume(components[number[id]], triangle, center, scale);
        } else {
            components[number[id]].sealed = false;
        }
    }
    for (std::uint32_t id = 0; id < topology.edge_count(); ++id) {
        const EdgeUse use = edge_use(mesh, topology, EdgeId{id});
        if (!use.is_open() && !use.is_inconsistent()) continue;
        for (const TriangleId triangle : topology.triangles(EdgeId{id})) {
            if (!is_proper(mesh.triangles()[index(triangle)])) continue;
            components[number[index(triangle)]].sealed = false;
        }
    }
    return components;
}

} // namespace proxima::detail
