#include "mesh/surface_parts.h"

#include "base/disjoint_sets.h"
#include "mesh/coincidence.h"
#include "mesh/equal_items.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima::detail {

namespace {

// Calls visit(a, b, edge) so that the chain of its pairs connects all proper triangles of an edge.
template <class Visit>
void for_neighbours(const TriangleMesh& mesh, const Topology& topology, const Visit& visit)
{
    for (std::uint32_t id = 0; id < topology.edge_count(); ++id) {
        TriangleId previous = no_triangle;
        for (const TriangleId triangle : topology.triangles(EdgeId{id})) {
            if (!is_proper(mesh.triangles()[to_index(triangle)])) continue;
            if (previous != no_triangle) visit(previous, triangle, EdgeId{id});
            previous = triangle;
        }
    }
}

} // namespace

std::vector<EdgeUse> edge_uses(const TriangleMesh& mesh, const Topology& topology)
{
    std::vector<EdgeUse> uses(topology.edge_count());
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const TriangleCorners& corners = mesh.triangles()[id];
        if (!is_proper(corners)) continue;
        const auto& sides = topology.edges(TriangleId{id});
        for (std::size_t k = 0; k < 3; ++k) {
            EdgeUse& use = uses[to_index(sides[k])];
            ++(corners[k] < corners[(k + 1) % 3] ? use.forward : use.backward);
        }
    }
    return uses;
}

std::uint64_t boundary_loops(const Topology& topology, std::span<const EdgeUse> uses)
{
    const auto vertices = static_cast<std::uint32_t>(topology.vertex_count());
    DisjointSets loops(vertices);
    std::vector<bool> on_boundary(vertices, false);
    for (std::uint32_t id = 0; id < topology.edge_count(); ++id) {
        if (uses[id].total() != 1) continue;
        const auto [low, high] = topology.vertices(EdgeId{id});
        loops.unite(to_index(low), to_index(high));
        on_boundary[to_index(low)] = on_boundary[to_index(high)] = true;
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
        const TriangleCorners& corners = mesh.triangles()[to_index(triangle)];
        const auto found = std::find(corners.begin(), corners.end(), to_index(vertex));
        return 3 * to_index(triangle) + static_cast<std::uint32_t>(found - corners.begin());
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

std::vector<std::uint32_t> first_duplicates(const TriangleMesh& mesh)
{
    const std::span<const TriangleCorners> triangles = mesh.triangles();
    return first_equal_items(
        static_cast<std::uint32_t>(triangles.size()),
        [&](std::uint32_t i) { return is_proper(triangles[i]); },
        [&](std::uint32_t i) { return hash_of(sorted_corners(triangles[i])); },
        [&](std::uint32_t a, std::uint32_t b) {
            return sorted_corners(triangles[a]) == sorted_corners(triangles[b]);
        });
}

double unit_scale(double reach) noexcept
{
    constexpr int most = 1000; // so that the scale is finite
    return reach > 0 ? std::ldexp(1.0, std::clamp(-std::ilogb(reach) - 1, -most, most)) : 1.0;
}

void VolumeSum::add(const Triangle& triangle, const Vec3& origin, bool turned) noexcept
{
    const auto from = [this](const Vec3& p, const Vec3& to) -> Vec3 {
        // Differences of large numbers may overflow, and scaled small numbers vanish.
        constexpr double huge = 0x1p-800;
        if (scale < huge) return to * scale - p * scale;
        return (to - p) * scale;
    };
    const Vec3 normal = from(triangle[0], triangle[1]).cross(from(triangle[0], triangle[2]));
    const Vec3 from_origin = from(origin, triangle[0]);
    const double term = from_origin.dot(normal);
    volume += turned ? -term : term;
    magnitude += from_origin.norm() * normal.norm();
}

std::vector<VolumeSum> scaled_sums(const TriangleMesh& mesh,
                                   std::span<const std::uint32_t> surface_of, std::size_t count)
{
    std::vector<Box> boxes(count);
    for (std::uint32_t id = 0; id < surface_of.size(); ++id) {
        if (surface_of[id] == no_surface_sum) continue;
        const Triangle triangle = mesh.triangle(TriangleId{id});
        if (!is_finite(triangle)) continue;
        for (const Vec3& corner : triangle.vertices) boxes[surface_of[id]].extend(corner);
    }
    std::vector<VolumeSum> sums(count);
    for (std::size_t i = 0; i < count; ++i) {
        if (boxes[i].empty()) continue;
        const double extent = boxes[i].extent().maxCoeff();
        constexpr double largest = std::numeric_limits<double>::max();
        sums[i].scale = unit_scale(std::min(extent, largest));
    }
    return sums;
}

std::vector<SurfaceComponent> surface_components(const TriangleMesh& mesh, const Topology& topology,
                                                 std::span<const EdgeUse> uses)
{
    const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
    DisjointSets sets(count);
    for_neighbours(mesh, topology, [&](TriangleId a, TriangleId b, EdgeId) {
        sets.unite(to_index(a), to_index(b));
    });

    std::vector<SurfaceComponent> components;
    std::vector<std::uint32_t> number(count, no_surface_sum);
    for (std::uint32_t id = 0; id < count; ++id) {
        if (!is_proper(mesh.triangles()[id])) continue;
        const std::uint32_t root = sets.find(id); // the lowest id: its number is known
        if (root == id) {
            number[id] = static_cast<std::uint32_t>(components.size());
            components.push_back({.first_triangle = id});
        }
        number[id] = number[root];
    }
    std::vector<VolumeSum> sums = scaled_sums(mesh, number, components.size());
    for (std::size_t i = 0; i < components.size(); ++i) components[i].volume = sums[i];
    for (std::uint32_t id = 0; id < count; ++id) {
        if (number[id] == no_surface_sum) continue;
        SurfaceComponent& component = components[number[id]];
        const Triangle triangle = mesh.triangle(TriangleId{id});
        if (is_finite(triangle)) {
            const TriangleId first{component.first_triangle};
            component.volume.add(triangle, mesh.triangle(first)[0]);
        } else {
            component.sealed = false;
        }
    }
    for (std::uint32_t id = 0; id < topology.edge_count(); ++id) {
        if (!uses[id].is_open() && !uses[id].is_inconsistent()) continue;
        for (const TriangleId triangle : topology.triangles(EdgeId{id})) {
            if (!is_proper(mesh.triangles()[to_index(triangle)])) continue;
            components[number[to_index(triangle)]].sealed = false;
        }
    }
    return components;
}

} // namespace proxima::detail
