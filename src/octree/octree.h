// The immutable octree: who its cells are, which triangles touch them, inner, outer or boundary.
//
//     nodes       8 bytes each, only for split cells and occupied leaves (uniform trees: all cells)
//       split     { first child record, recorded-children mask 8 | inner-children mask 8 | empty
//       bit } leaf      { first reference, leaf bit 31 | count 30 }
//     references  triangle ids, ascending within a leaf, a leaf's contiguous
//
// An empty child is no record, only a clear bit of the recorded mask; its class is its bit of the
// inner mask. Thesis section 2.1.
#pragma once

#include "base/result.h"
#include "mesh/triangle_mesh.h"
#include "octree/cell.h"

#include <bit>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

namespace proxima {

/// Where a cell lies. A cell that a triangle touches is boundary (and so is every split cell that
/// contains such a cell); the others are wholly outside or inside the surface.
enum class CellClass : std::uint8_t { outer, inner, boundary, unclassified };

/// Whether every cell is split to the maximum depth, or only the crowded ones.
enum class Subdivision : std::uint8_t { adaptive, uniform };

/// Which overlap test of a triangle and a cell found an octree's lists (thesis chapter 3).
/// build_octree uses the first; the thesis layer builds with all.
enum class OverlapMethod : std::uint8_t {
    fast,            ///< 17 half-spaces in vector lanes, exact where lanes are unsure
    index_tracking,  ///< thesis 3.5
    minkowski,       ///< thesis 3.2 to 3.4
    separating_axis, ///< thesis 3.6.3
    pairwise         ///< thesis 3.6.2
};

/// One record of the octree; see the picture above.
struct OctreeNode {
    std::uint32_t first = 0;
    std::uint32_t packed = 0;

    static constexpr std::uint32_t leaf_bit = 1U << 31U;
    static constexpr std::uint32_t empty_split_bit = 1U << 30U; ///< split, yet no triangle below
    static constexpr std::uint32_t max_leaf_count = (1U << 30U) - 1;

    [[nodiscard]] static constexpr OctreeNode leaf(std::uint32_t first_reference,
                                                   std::uint32_t count) noexcept
    {
        return {first_reference, leaf_bit | count};
    }
    [[nodiscard]] static constexpr OctreeNode split(std::uint32_t first_child,
                                                    std::uint32_t recorded_mask,
                                                    std::uint32_t inner_mask = 0) noexcept
    {
        return {first_child, recorded_mask | inner_mask << 8U};
    }
    [[nodiscard]] constexpr bool is_leaf() const noexcept { return (packed & leaf_bit) != 0; }
    [[nodiscard]] constexpr std::uint32_t count() const noexcept { return packed & ~leaf_bit; }
    /// No triangle touches it: only uniform trees have such records.
    [[nodiscard]] constexpr bool is_empty() const noexcept
    {
        return is_leaf() ? count() == 0 : (packed & empty_split_bit) != 0;
    }
    [[nodiscard]] constexpr std::uint32_t recorded_mask() const noexcept { return packed & 0xFFU; }
    [[nodiscard]] constexpr std::uint32_t inner_mask() const noexcept
    {
        return packed >> 8U & 0xFFU;
    }
    friend constexpr bool operator==(const OctreeNode&, const OctreeNode&) = default;
};
static_assert(sizeof(OctreeNode) == 8);

/// A cell of one octree, as traversals hand it around: a value of 24 bytes.
struct Cell {
    static constexpr std::uint32_t no_node = std::numeric_limits<std::uint32_t>::max();

    CellKey key;
    std::uint32_t node = no_node; ///< its record, no_node for an empty leaf without one
    CellClass type = CellClass::unclassified;
};

/// What the classification of empty leaves met; see classify_cells.h.
struct ClassificationSummary {
    std::uint32_t components = 0;        ///< face-connected components of empty leaves
    std::uint32_t leaked_components = 0; ///< those reaching both sides through a hole of the mesh
    std::uint64_t leaked_leaves = 0;     ///< their leaves, classified one by one
    friend bool operator==(const ClassificationSummary&, const ClassificationSummary&) = default;
};

/// How an octree was built; kept with it and in its file.
struct OctreeParameters {
    int max_depth = 0;
    std::uint32_t threshold = 0;
    OverlapMethod method = OverlapMethod::fast;
    Subdivision subdivision = Subdivision::adaptive;
    bool exact = false;      ///< lists hold exactly the triangles that touch
    bool classified = false; ///< empty leaves are known to be inner or outer
    ClassificationSummary classification = {};
    friend bool operator==(const OctreeParameters&, const OctreeParameters&) = default;
};

/// Immutable; copies share the storage. All members are noexcept, do not allocate, and may be
/// called from any thread.
class Octree {
public:
    [[nodiscard]] const OctreeFrame& frame() const noexcept { return frame_; }
    [[nodiscard]] const OctreeParameters& parameters() const noexcept { return parameters_; }
    [[nodiscard]] std::span<const OctreeNode> nodes() const noexcept { return nodes_; }
    [[nodiscard]] std::span<const TriangleId> references() const noexcept { return references_; }

    /// Triangles of the mesh it was built from.
    [[nodiscard]] std::uint64_t triangle_count() const noexcept { return triangle_count_; }

    /// Bytes of nodes and references.
    [[nodiscard]] std::uint64_t bytes() const noexcept
    {
        return nodes_.size_bytes() + references_.size_bytes();
    }

    [[nodiscard]] Cell root() const noexcept { return {CellKey{}, 0, CellClass::boundary}; }

    [[nodiscard]] bool is_leaf(const Cell& cell) const noexcept
    {
        return cell.node == Cell::no_node || nodes_[cell.node].is_leaf();
    }

    /// \pre !is_leaf(cell), octant in [0, 8)
    [[nodiscard]] Cell child(const Cell& cell, int octant) const noexcept
    {
        const OctreeNode parent_node = nodes_[cell.node];
        const std::uint32_t bit = 1U << static_cast<unsigned>(octant);
        const CellClass empty_type = !parameters_.classified            ? CellClass::unclassified
                                     : (parent_node.inner_mask() & bit) ? CellClass::inner
                                                                        : CellClass::outer;
        if ((parent_node.recorded_mask() & bit) == 0) {
            return {proxima::child(cell.key, octant), Cell::no_node, empty_type};
        }
        const auto rank =
            static_cast<std::uint32_t>(std::popcount(parent_node.recorded_mask() & (bit - 1)));
        const std::uint32_t record = parent_node.first + rank;
        return {proxima::child(cell.key, octant), record,
                nodes_[record].is_empty() ? empty_type : CellClass::boundary};
    }

    /// Ids of the triangles that touch the leaf, ascending; empty for inner and outer ones.
    /// \pre is_leaf(cell)
    [[nodiscard]] std::span<const TriangleId> triangles(const Cell& cell) const noexcept
    {
        if (cell.node == Cell::no_node) return {};
        const OctreeNode node = nodes_[cell.node];
        return references_.subspan(node.first, node.count());
    }

    [[nodiscard]] Box box(const Cell& cell) const noexcept { return cell_box(frame_, cell.key); }

    /// Takes arrays that satisfy the layout above; `storage` keeps them alive. For builders, the
    /// file reader and editors that make a changed copy; they check, this does not.
    [[nodiscard]] static Octree adopt(const OctreeFrame& frame, const OctreeParameters& parameters,
                                      std::uint64_t triangle_count,
                                      std::span<const OctreeNode> nodes,
                                      std::span<const TriangleId> references,
                                      std::shared_ptr<const void> storage) noexcept;

private:
    OctreeFrame frame_;
    OctreeParameters parameters_;
    std::uint64_t triangle_count_ = 0;
    std::span<const OctreeNode> nodes_;
    std::span<const TriangleId> references_;
    std::shared_ptr<const void> storage_;
};

} // namespace proxima
