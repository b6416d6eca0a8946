// One structure for all queries of a mesh: the octree's cells, eight children to a node, with boxes
// drawn tight around what they hold, and every triangle in one place.
//
//     frame    centre and scale: coordinates of blocks are in units of the mesh's size
//     blocks   128 bytes each, a node's children side by side
//       node   8 boxes of 6 bytes: plane = origin + (32768 + byte) step, outward; 8 references
//       leaf   up to 8 triangles among up to 8 vertices: coordinates in floats, corners as bytes
//     rows     the triangles in the order of the leaves (triangle_row.h), in doubles, or in floats
//              where these are the same: corners, ids, vertices, edges; below a block they are a run
//     ids      the triangle ids of the rows, side by side
//     places   of each vertex and edge, its lowest triangle and where it is there (place_word)
//
// The order of the rows is the Morton curve of the octree's cells by the triangles' centres. Chains
// of cells with a single child are left out, and levels are joined where that makes fewer steps.
#pragma once

#include "geometry/shapes.h"
#include "index/triangle_row.h"
#include "mesh/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace proxima {

/// Eight boxes; places without a child have boxes that no ray meets, and refer to an empty leaf.
struct IndexNode {
    std::array<std::array<std::uint8_t, 16>, 3> planes; ///< by axis: 8 lower, 8 upper
    std::array<std::uint32_t, 8> children;              ///< by octant of the node, more or less
    std::array<float, 3> origin;
    std::array<float, 3> step;
    std::uint32_t first_row; ///< of the run of rows below
    std::uint32_t order;     ///< places of the children by their rows, 4 bits each from the lowest
                             ///< up; no_child after the last
    std::array<std::uint16_t, 8> starts; ///< by place: where a child's run begins, from first_row
                                         ///< on; far_start: as its own block says

    static constexpr std::uint32_t no_child = 15;
    static constexpr std::uint16_t far_start = 0xFFFF;
};

/// Triangles by bytes into the vertices.
struct IndexLeaf {
    std::array<std::array<float, 8>, 3> coordinates; ///< by axis
    std::array<std::array<std::uint8_t, 8>, 3> corners;
    std::uint32_t first_row;
    std::uint16_t count;
    std::uint16_t extent_bits; ///< upper half of a float: the edge of its box, rounded up
};

/// Which of the two it is, the reference to it says.
union alignas(128) IndexBlock {
    IndexNode node;
    IndexLeaf leaf;
};
static_assert(sizeof(IndexBlock) == 128);

/// References are places of blocks, with this bit for leaves.
inline constexpr std::uint32_t index_leaf_bit = 1U << 31U;

/// The most triangles that rows have ids for.
inline constexpr std::size_t max_index_triangles = std::size_t{1} << 28U;

/// Immutable; copies share the storage. Thread safe. Made by build_mesh_index.
class MeshIndex {
public:
    /// Levels of blocks at most: the 63 bits of a cell's place, then 31 of a triangle's rank.
    static constexpr std::size_t max_levels = 63 + 31;

    [[nodiscard]] std::uint32_t triangle_count() const noexcept { return triangle_count_; }
    [[nodiscard]] std::size_t vertex_count() const noexcept { return vertex_places_.size(); }
    [[nodiscard]] std::size_t edge_count() const noexcept { return edge_places_.size(); }
    [[nodiscard]] std::span<const IndexBlock> blocks() const noexcept { return blocks_; }
    [[nodiscard]] std::uint32_t root() const noexcept { return root_; }
    [[nodiscard]] std::span<const TriangleRow<float>> float_rows() const noexcept
    {
        return float_rows_;
    }
    [[nodiscard]] std::span<const TriangleRow<double>> double_rows() const noexcept
    {
        return double_rows_;
    }

    /// Ids of the triangles in the order of the leaves.
    [[nodiscard]] std::span<const TriangleId> ids() const noexcept { return ids_; }
    /// The corners of a row. \pre row < triangle_count()
    [[nodiscard]] Triangle triangle(std::uint32_t row) const noexcept
    {
        return double_rows_.empty() ? float_rows_[row].corners() : double_rows_[row].corners();
    }
    /// The id of a row's triangle. \pre row < triangle_count()
    [[nodiscard]] TriangleId id(std::uint32_t row) const noexcept { return ids_[row]; }

    /// Of each vertex and each edge of the mesh, by id: its lowest triangle and where it is there
    /// (place_word). Edges are numbered as Topology does.
    [[nodiscard]] std::span<const std::uint32_t> vertex_places() const noexcept
    {
        return vertex_places_;
    }
    [[nodiscard]] std::span<const std::uint32_t> edge_places() const noexcept
    {
        return edge_places_;
    }

    /// Whether coordinate * unscale() + center() of a leaf's vertex, in doubles, is the mesh's own.
    [[nodiscard]] bool has_exact_leaves() const noexcept { return has_exact_leaves_; }

    /// Blocks are in multiples of unscale(), 1 / scale(), from center(). The scale is a power of
    /// two, and the mesh within [-1, 1] on each axis.
    [[nodiscard]] const Vec3& center() const noexcept { return center_; }
    [[nodiscard]] double scale() const noexcept { return scale_; }
    [[nodiscard]] double unscale() const noexcept { return unscale_; }

    /// Bytes of all arrays.
    [[nodiscard]] std::uint64_t bytes() const noexcept
    {
        return blocks_.size_bytes() + float_rows_.size_bytes() + double_rows_.size_bytes() +
               ids_.size_bytes() + vertex_places_.size_bytes() + edge_places_.size_bytes();
    }

private:
    friend class MeshIndexWriter;

    Vec3 center_ = Vec3::Zero();
    double scale_ = 1;
    double unscale_ = 1;
    std::uint32_t root_ = 0;
    std::uint32_t triangle_count_ = 0;
    bool has_exact_leaves_ = false;
    std::span<const IndexBlock> blocks_;
    std::span<const TriangleRow<float>> float_rows_; ///< or double_rows_, not both
    std::span<const TriangleRow<double>> double_rows_;
    std::span<const TriangleId> ids_;
    std::span<const std::uint32_t> vertex_places_;
    std::span<const std::uint32_t> edge_places_;
    std::shared_ptr<const void> storage_;
};

} // namespace proxima
