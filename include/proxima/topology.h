// The features of a mesh and their neighbours: edges with all their triangles, vertex stars.
//
//     edge       two vertices (ascending) and its 1, 2 or more triangles (ascending)
//     triangle   three edges: edge k joins corner k and corner k + 1
//     vertex     its star: all triangles (ascending), and all edges (ascending)
//
// Edge ids count the edges by first appearance over the triangles ascending, edges (v0v1, v1v2,
// v2v0). A triangle that repeats a vertex is a segment or a point: (a, a, b) has no edge at aa and
// the edge ab at both other sides, listed there once; (a, a, a) has none. Such a triangle appears
// once in the star of each of its vertices. Thesis 4.3.2 works on these features.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

/// Ordered by dimension.
enum class FeatureKind : std::uint8_t { vertex, edge, face };

/// One feature: a VertexId, an EdgeId of the topology, or a TriangleId as a plain number.
struct Feature {
    FeatureKind kind = FeatureKind::vertex;
    std::uint32_t id = 0;

    friend constexpr bool operator==(const Feature&, const Feature&) = default;
    /// By kind (vertex < edge < face), then id: the order that settles ties.
    // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 sees a null where comparisons are made
    friend constexpr std::strong_ordering operator<=>(const Feature&, const Feature&) = default;
};

enum class EdgeId : std::uint32_t {};

[[nodiscard]] constexpr std::uint32_t to_index(EdgeId id) noexcept
{
    return static_cast<std::uint32_t>(id);
}

/// The side of a degenerate triangle that joins a vertex with itself.
inline constexpr EdgeId no_edge{std::numeric_limits<std::uint32_t>::max()};

/// No triangle, or not a single one.
inline constexpr TriangleId no_triangle{std::numeric_limits<std::uint32_t>::max()};

/// The vertices of an edge, ascending.
using EdgeVertices = std::array<VertexId, 2>;

/// Past this, references no longer fit 32 bits.
inline constexpr std::size_t max_topology_triangles = std::numeric_limits<std::uint32_t>::max() / 6;

struct TopologyOptions {
    Execution execution = {}; ///< budget: result and scratch, without the mesh
};

/// Immutable. All members are noexcept, do not allocate, and may be called from any thread.
/// Ids must be in range.
class Topology {
public:
    Topology() = default;

    [[nodiscard]] std::size_t vertex_count() const noexcept { return vertex_count_; }
    [[nodiscard]] std::size_t edge_count() const noexcept { return edge_vertices_.size(); }
    [[nodiscard]] std::size_t triangle_count() const noexcept { return triangle_edges_.size(); }

    [[nodiscard]] const EdgeVertices& vertices(EdgeId edge) const noexcept
    {
        return edge_vertices_[to_index(edge)];
    }

    /// All triangles of the edge, ascending: one on a boundary, two inside a surface, or more.
    [[nodiscard]] std::span<const TriangleId> triangles(EdgeId edge) const noexcept
    {
        return slice(edge_triangles_, edge_first_, to_index(edge));
    }

    /// Edge k joins corner k and corner k + 1; no_edge where they are the same vertex.
    [[nodiscard]] const std::array<EdgeId, 3>& edges(TriangleId triangle) const noexcept
    {
        return triangle_edges_[to_index(triangle)];
    }

    /// The star: all triangles that use the vertex, ascending; empty for an unreferenced one.
    [[nodiscard]] std::span<const TriangleId> triangles(VertexId vertex) const noexcept
    {
        return slice(star_triangles_, star_first_, to_index(vertex));
    }

    /// All edges at the vertex, ascending; other_end() gives its neighbours.
    [[nodiscard]] std::span<const EdgeId> edges(VertexId vertex) const noexcept
    {
        return slice(vertex_edges_, vertex_edges_first_, to_index(vertex));
    }

    /// The other vertex of an edge at `vertex`. \pre vertex is one of the edge's
    [[nodiscard]] VertexId other_end(EdgeId edge, VertexId vertex) const noexcept
    {
        const auto [low, high] = vertices(edge);
        return vertex == low ? high : low;
    }

    /// The edge that joins the two vertices; no_edge where there is none. O(edges at a vertex).
    [[nodiscard]] EdgeId find_edge(VertexId a, VertexId b) const noexcept;

    /// The one triangle on the other side of the triangle's edge `side` (0, 1 or 2); no_triangle
    /// on a boundary, at a non-manifold edge, and where the side is no edge.
    [[nodiscard]] TriangleId across(TriangleId triangle, int side) const noexcept
    {
        const EdgeId edge = edges(triangle)[static_cast<std::size_t>(side)];
        if (edge == no_edge) return no_triangle;
        const std::span<const TriangleId> both = triangles(edge);
        if (both.size() != 2) return no_triangle;
        return both[0] == triangle ? both[1] : both[0];
    }

    /// Memory of the arrays.
    [[nodiscard]] std::uint64_t bytes() const noexcept;

private:
    friend class TopologyBuilder;

    template <class Id>
    [[nodiscard]] static std::span<const Id> slice(const std::vector<Id>& items,
                                                   const std::vector<std::uint32_t>& first,
                                                   std::size_t item) noexcept
    {
        return std::span(items).subspan(first[item], first[item + 1] - first[item]);
    }

    std::size_t vertex_count_ = 0;
    std::vector<EdgeVertices> edge_vertices_;
    std::vector<std::uint32_t> edge_first_; ///< edge e's triangles: [edge_first_[e], [e + 1])
    std::vector<TriangleId> edge_triangles_;
    std::vector<std::array<EdgeId, 3>> triangle_edges_;
    std::vector<std::uint32_t> star_first_;
    std::vector<TriangleId> star_triangles_;
    std::vector<std::uint32_t> vertex_edges_first_;
    std::vector<EdgeId> vertex_edges_;
};

/// Builds the topology of any mesh, positions unseen; the same for any number of threads.
/// Errors: limit_exceeded (more than max_topology_triangles), budget_exceeded, cancelled. Linear
/// time, except that the star of a vertex with many triangles is sorted; 70 bytes per triangle of
/// a closed mesh and 54 of scratch.
[[nodiscard]] Result<Topology> build_topology(const TriangleMesh& mesh,
                                              const TopologyOptions& options = {});

} // namespace proxima
