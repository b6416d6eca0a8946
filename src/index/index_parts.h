// What a mesh index holds: one structure for all queries of a mesh. The octree's cells, eight children
// to a node, with boxes drawn tight around what they hold, and every triangle once.
//
//     frame    centre and scale: coordinates of blocks are in units of the mesh's size
//     blocks   128 bytes each, a node's children side by side
//       node   8 boxes of 6 bytes: plane = origin + (32768 + byte) step, outward; 8 references
//       leaf   up to 8 triangles among up to 8 vertices: coordinates in floats, corners as bytes
//     rows     the triangles in the order of the leaves (triangle_row.h), in doubles, or in floats
//              where these are the same: corners, ids, vertices, edges; below a block they are a run
//     ids      the triangle ids of the rows, side by side
//     incidences  of each vertex and edge, its lowest triangle and where it is there (incidence)
//
// Optional additions: lists (lists/proximity_lists.h), slabs (slabs/block_slab.h) and signs
// (signs/sign_parts.h).
//
// The order of the rows is the Morton curve of the octree's cells by the triangles' centres. Chains
// of cells with a single child are left out, and levels are joined where that makes fewer steps.
#pragma once

#include "index/triangle_row.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

namespace proxima {

/// Eight boxes; slots without a child have boxes that no ray meets, and refer to an empty leaf.
struct IndexNode {
    std::array<std::array<std::uint8_t, 16>, 3> planes; ///< by axis: 8 lower, 8 upper
    std::array<std::uint32_t, 8> children;              ///< by octant of the node, more or less
    std::array<float, 3> origin;
    std::array<float, 3> step;
    std::uint32_t first_row; ///< of the run of rows below
    std::uint32_t order;     ///< slots of the children by their rows, 4 bits each from the lowest
                             ///< up; no_child after the last
    std::array<std::uint16_t, 8> starts; ///< by slot: where a child's run begins, from first_row
                                         ///< on; far_start: as its own block says

    /// Where a plane lies: `at` is a slot for its lower one, 8 more for its upper one.
    [[nodiscard]] double plane(std::size_t axis, std::size_t at) const noexcept
    {
        return static_cast<double>(origin[axis]) +
               (32768.0 + planes[axis][at]) * static_cast<double>(step[axis]);
    }
    /// Slots without a child have their planes in the wrong order.
    [[nodiscard]] bool has_child(std::size_t slot) const noexcept
    {
        return planes[0][slot] <= planes[0][8 + slot];
    }

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

/// References are positions of blocks, with this bit for leaves.
inline constexpr std::uint32_t index_leaf_bit = 1U << 31U;

/// A box about all that blocks hold, by more than their boxes are drawn out. A fourth axis fills
/// vectors: nothing there is outside.
struct RootBox {
    alignas(32) std::array<double, 4> lower;
    alignas(32) std::array<double, 4> upper;

    /// How far it lies beyond the root's planes.
    static constexpr double margin = 0.01;
};

struct BlockSlab;
class ProximityLists;
class SignParts;

/// The frame and the arrays that every mesh index has.
struct IndexArrays {
    Vec3 center = Vec3::Zero();
    double scale = 1;
    std::uint64_t fingerprint = 0;
    std::uint32_t root = 0;
    bool has_exact_leaves = false;
    std::span<const IndexBlock> blocks;
    std::span<const TriangleRow<float>> float_rows; ///< or double_rows, not both
    std::span<const TriangleRow<double>> double_rows;
    std::span<const TriangleId> ids;
    std::span<const std::uint32_t> vertex_incidences;
    std::span<const std::uint32_t> edge_incidences;
};

/// Immutable; copies share the storage. Thread safe. Searches are handed this, not the MeshIndex that
/// holds it: a step of a search follows no pointer to get here.
class PROXIMA_HIDDEN IndexParts {
public:
    /// Levels of blocks at most: the 63 bits of a cell's position, then 31 of a triangle's rank.
    static constexpr std::size_t max_levels = 63 + 31;

    /// What the functions below read, for a file of it.
    [[nodiscard]] const IndexArrays& arrays() const noexcept { return arrays_; }

    [[nodiscard]] std::uint32_t triangle_count() const noexcept
    {
        return static_cast<std::uint32_t>(arrays_.ids.size());
    }
    [[nodiscard]] std::size_t vertex_count() const noexcept
    {
        return arrays_.vertex_incidences.size();
    }
    [[nodiscard]] std::size_t edge_count() const noexcept { return arrays_.edge_incidences.size(); }
    [[nodiscard]] std::span<const IndexBlock> blocks() const noexcept { return arrays_.blocks; }
    [[nodiscard]] std::uint32_t root() const noexcept { return arrays_.root; }
    [[nodiscard]] std::span<const TriangleRow<float>> float_rows() const noexcept
    {
        return arrays_.float_rows;
    }
    [[nodiscard]] std::span<const TriangleRow<double>> double_rows() const noexcept
    {
        return arrays_.double_rows;
    }

    /// Ids of the triangles in the order of the leaves.
    [[nodiscard]] std::span<const TriangleId> ids() const noexcept { return arrays_.ids; }
    /// The corners of a row. \pre row < triangle_count()
    [[nodiscard]] Triangle triangle(std::uint32_t row) const noexcept
    {
        return arrays_.double_rows.empty() ? arrays_.float_rows[row].corners()
                                           : arrays_.double_rows[row].corners();
    }
    /// The id of a row's triangle. \pre row < triangle_count()
    [[nodiscard]] TriangleId id(std::uint32_t row) const noexcept { return arrays_.ids[row]; }

    /// Of each vertex and each edge of the mesh, by id: its lowest triangle and where it is there
    /// (incidence). Edges are numbered as Topology does.
    [[nodiscard]] std::span<const std::uint32_t> vertex_incidences() const noexcept
    {
        return arrays_.vertex_incidences;
    }
    [[nodiscard]] std::span<const std::uint32_t> edge_incidences() const noexcept
    {
        return arrays_.edge_incidences;
    }

    /// Whether coordinate * unscale() + center() of a leaf's vertex, in doubles, is the mesh's own.
    [[nodiscard]] bool has_exact_leaves() const noexcept { return arrays_.has_exact_leaves; }

    /// Blocks are in multiples of unscale(), 1 / scale(), from center(). The scale is a power of
    /// two, and the mesh within [-1, 1] on each axis.
    [[nodiscard]] const Vec3& center() const noexcept { return arrays_.center; }
    [[nodiscard]] double scale() const noexcept { return arrays_.scale; }
    [[nodiscard]] double unscale() const noexcept { return unscale_; }

    /// In units of the blocks.
    [[nodiscard]] const RootBox& root_box() const noexcept { return root_box_; }

    /// Identifies the mesh: positions and triangles, see mesh_fingerprint().
    [[nodiscard]] std::uint64_t mesh_fingerprint() const noexcept { return arrays_.fingerprint; }

    /// Closest-feature lists (proximity_lists.h); null where there are none.
    [[nodiscard]] const ProximityLists* lists() const noexcept { return lists_.get(); }

    /// Slabs about all blocks (block_slab.h) and seven more to be read along; empty where there are
    /// none.
    [[nodiscard]] std::span<const BlockSlab> slabs() const noexcept { return slabs_; }

    /// Signs (sign_parts.h); null where there are none.
    [[nodiscard]] const SignParts* signs() const noexcept { return signs_.get(); }

    /// Takes arrays that satisfy the layout above; `storage` keeps them alive. These four are for
    /// builders and the file reader: they check, these do not.
    [[nodiscard]] static IndexParts adopt(const IndexArrays& arrays,
                                          std::shared_ptr<const void> storage) noexcept;
    [[nodiscard]] IndexParts
    adopt_lists(std::shared_ptr<const ProximityLists> lists) const noexcept;
    [[nodiscard]] IndexParts adopt_slabs(std::span<const BlockSlab> slabs,
                                         std::shared_ptr<const void> storage) const noexcept;
    [[nodiscard]] IndexParts adopt_signs(std::shared_ptr<const SignParts> signs) const noexcept;

private:
    IndexArrays arrays_;
    double unscale_ = 1;
    RootBox root_box_ = {};
    std::shared_ptr<const void> storage_;
    std::shared_ptr<const ProximityLists> lists_;
    std::span<const BlockSlab> slabs_;
    std::shared_ptr<const void> slab_storage_;
    std::shared_ptr<const SignParts> signs_;
};

/// What a unit of the blocks is in the mesh's coordinates: unscale(), but 0 where all triangles are one
/// point, whose frame has no size. Looks at triangles until two corners differ. Thread safe.
[[nodiscard]] double block_unit(const IndexParts& index) noexcept;

/// The index that holds these parts.
[[nodiscard]] inline MeshIndex make_mesh_index(IndexParts parts)
{
    return MeshIndex(std::make_shared<const IndexParts>(std::move(parts)));
}

} // namespace proxima
