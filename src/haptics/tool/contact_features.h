// The vertices and edges of a mesh that can touch another mesh, and what surrounds them.
//
//     edge      can touch unless it lies in one plane with both of its triangles
//     vertex    can touch unless all its edges lie in one plane
//     owner     the lowest triangle at a vertex or an edge: it alone tells of contacts there
//
// Vertices at one position are one vertex, whatever their ids.
#pragma once

#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// A triangle, named by its row in the index.
struct FeatureRow {
    std::array<std::uint32_t, 3> vertices = {};
    std::array<std::uint32_t, 3> edges = {}; ///< edge k joins corner k and corner k + 1
    std::uint8_t owned_vertices = 0;         ///< bits of the corners that it tells of
    std::uint8_t owned_edges = 0;            ///< bits of the sides that it tells of

    [[nodiscard]] bool owns_any() const noexcept { return owned_vertices != 0 || owned_edges != 0; }
};

/// Immutable. Queries are noexcept.
class ContactFeatures {
public:
    /// Errors: those of mesh_of and build_topology. O(triangles log triangles).
    [[nodiscard]] static Result<ContactFeatures> build(const MeshIndex& index);

    [[nodiscard]] const FeatureRow& row(std::uint32_t row) const noexcept { return rows_[row]; }
    [[nodiscard]] const Vec3& position(std::uint32_t vertex) const noexcept
    {
        return positions_[vertex];
    }
    /// The other ends of the edges at a vertex.
    [[nodiscard]] std::span<const std::uint32_t> around_vertex(std::uint32_t vertex) const noexcept
    {
        return slice(vertex_first_, vertex_ring_, vertex);
    }
    /// The third corners of the triangles at an edge.
    [[nodiscard]] std::span<const std::uint32_t> around_edge(std::uint32_t edge) const noexcept
    {
        return slice(edge_first_, edge_ring_, edge);
    }
    /// Largest distance of a vertex from the origin.
    [[nodiscard]] double reach() const noexcept { return reach_; }
    [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }

private:
    using Numbers = std::vector<std::uint32_t>;
    [[nodiscard]] static std::span<const std::uint32_t>
    slice(const Numbers& first, const Numbers& items, std::uint32_t at) noexcept
    {
        return std::span(items).subspan(first[at], first[at + 1] - first[at]);
    }

    std::vector<FeatureRow> rows_;
    std::vector<Vec3> positions_;
    Numbers vertex_first_;
    Numbers vertex_ring_;
    Numbers edge_first_;
    Numbers edge_ring_;
    double reach_ = 0;
    Box bounds_;
};

} // namespace proxima
