// What rays are cast against: the octree's cells once more, eight children at a time, with boxes
// drawn tight around what they hold and every triangle in one place.
//
//     blocks   128 bytes each, a node's children side by side
//       node   8 boxes of 6 bytes: plane = origin + (32768 + byte) step, outward; 8 references
//       leaf   up to 8 triangles among up to 8 vertices: coordinates in floats, corners as bytes
//     rows     the triangles in the order of the leaves, in doubles (or floats where that is the
//              same), with their ids: what hits are computed from, unless leaves hold the same;
//              below a block they are a run
//     ids      those of the rows once more, on their own
//
// Where the octree keeps a triangle in every leaf that it touches, here it is kept in the cell in
// which its centre lies; chains of cells with a single child are left out, and levels joined where
// that makes fewer steps. Coordinates of blocks are in units of the mesh's size about its centre.
#pragma once

#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

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

/// A triangle and its id in the mesh.
template <class Scalar>
struct IndexRow {
    std::array<std::array<Scalar, 3>, 3> corners;
    std::uint32_t id;

    [[nodiscard]] Triangle triangle() const noexcept
    {
        Triangle result;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                result.vertices[i][static_cast<int>(axis)] = static_cast<double>(corners[i][axis]);
        }
        return result;
    }
};

/// Immutable; copies share the storage. Thread safe. Made by build_mesh_index.
class MeshIndex {
public:
    /// Levels of blocks at most: the 63 bits of a cell's place, then 31 of a triangle's rank.
    static constexpr std::size_t max_levels = 63 + 31;

    [[nodiscard]] std::uint32_t triangle_count() const noexcept { return triangle_count_; }
    [[nodiscard]] std::span<const IndexBlock> blocks() const noexcept { return blocks_; }
    [[nodiscard]] std::uint32_t root() const noexcept { return root_; }
    [[nodiscard]] std::span<const IndexRow<float>> float_rows() const noexcept
    {
        return float_rows_;
    }
    [[nodiscard]] std::span<const IndexRow<double>> double_rows() const noexcept
    {
        return double_rows_;
    }

    /// Ids of the triangles in the order of the leaves.
    [[nodiscard]] std::span<const TriangleId> ids() const noexcept { return ids_; }
    /// The triangle of a row. \pre row < triangle_count()
    [[nodiscard]] Triangle triangle(std::uint32_t row) const noexcept
    {
        return double_rows_.empty() ? float_rows_[row].triangle() : double_rows_[row].triangle();
    }

    /// Whether coordinate * unscale() + center() of a leaf's vertex, in doubles, is the mesh's own.
    [[nodiscard]] bool has_exact_leaves() const noexcept { return has_exact_leaves_; }

    /// Blocks are in multiples of unscale(), 1 / scale(), from center(). The scale is a power of
    /// two, and the mesh within [-1, 1] on each axis.
    [[nodiscard]] const Vec3& center() const noexcept { return center_; }
    [[nodiscard]] double scale() const noexcept { return scale_; }
    [[nodiscard]] double unscale() const noexcept { return unscale_; }

    /// Bytes of blocks, rows and ids.
    [[nodiscard]] std::uint64_t bytes() const noexcept
    {
        return blocks_.size_bytes() + float_rows_.size_bytes() + double_rows_.size_bytes() +
               ids_.size_bytes();
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
    std::span<const IndexRow<float>> float_rows_; ///< or double_rows_, not both
    std::span<const IndexRow<double>> double_rows_;
    std::span<const TriangleId> ids_;
    std::shared_ptr<const void> storage_;
};

} // namespace proxima
