#include "mesh/surface_parts.h"

#include "base/disjoint_sets.h"

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
            if (!is_proper(mesh.triangles()[to_index(triangle)])) continue;
            if (previous != no_triangle) visit(previous, triangle, EdgeId{id});
            previous = triangle;
        }
    }
}

/// Scales points so that the longest side of the bounds is 1, however small it was.
class UnitBounds {
public:
    explicit UnitBounds(const Box& bounds) noexcept
    {
        if (bounds.empty()) return;
        center_ = bounds.center();
        const double extent = bounds.extent().maxCoeff();
        if (!(extent > 0)) return;
        constexpr double least = 0x1p-1000; // of what has an inverse
        if (extent < least) enlarge_ = 1 / least;
        scale_ = 1 / (extent * enlarge_);
    }

    [[nodiscard]] Vec3 operator()(const Vec3& p) const noexcept
    {
        return (p - center_) * enlarge_ * scale_;
    }

private:
    Vec3 center_ = Vec3::Zero();
    double enlarge_ = 1;
    double scale_ = 1;
};

void add_volume(SurfaceComponent& component, const Triangle& triangle,
                const UnitBounds& unit) noexcept
{
    const Vec3 a = unit(triangle[0]);
    const Vec3 b = unit(triangle[1]);
    const Vec3 c = unit(triangle[2]);
    const double term = a.dot(b.cross(c)) / 6.0;
    component.volume += term;
    component.magnitude += std::abs(term);
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

std::vector<std::uint32_t> first_duplicates(const TriangleMesh& mesh, const Topology& topology)
{
    const auto ids = [&](TriangleId triangle) {
        TriangleCorners corners = mesh.triangles()[to_index(triangle)];
        std::sort(corners.begin(), corners.end());
        return corners;
    };
    std::vector<std::uint32_t> first(mesh.triangle_count());
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        first[id] = id;
        if (!is_proper(mesh.triangles()[id])) continue;
        // Equal triangles share all edges, so it is enough to look at the edge with the fewest
        // triangles.
        std::span<const TriangleId> around = topology.triangles(topology.edges(TriangleId{id})[0]);
        for (const EdgeId edge : topology.edges(TriangleId{id})) {
            const auto others = topology.triangles(edge);
            if (others.size() < around.size()) around = others;
        }
        const TriangleCorners own = ids(TriangleId{id});
        const auto found = std::find_if(around.begin(), around.end(), [&](TriangleId other) {
            return other == TriangleId{id} || ids(other) == own;
        });
        first[id] = to_index(*found);
    }
    return first;
}

std::vector<SurfaceComponent> surface_components(const TriangleMesh& mesh, const Topology& topology,
                                                 std::span<const EdgeUse> uses, const Box& bounds)
{
    const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
    DisjointSets sets(count);
    for_neighbours(mesh, topology, [&](TriangleId a, TriangleId b, EdgeId) {
        sets.unite(to_index(a), to_index(b));
    });

    std::vector<SurfaceComponent> components;
    std::vector<std::uint32_t> number(count, 0);
    const UnitBounds unit(bounds);
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
            add_volume(components[number[id]], triangle, unit);
        } else {
            components[number[id]].sealed = false;
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
