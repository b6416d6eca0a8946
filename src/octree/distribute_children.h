// From one level of split cells to the next: hands triangles to the children they touch.
//
//     level      cells  [record, first, count, centre] ...      all of them are split
//                pairs  triangle: 0 3 7 | 0 1 2 3 9 | ...       a cell's pairs are contiguous
//     children   crowded ones become cells of the next level, the others leaves in the output
#pragma once

#include "base/grow_buffer.h"
#include "octree/snapped_overlap.h"
#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// A cell that will be split, and its run of pairs.
struct SplitCell {
    static constexpr std::uint32_t no_record = 0xFFFFFFFFU;

    std::uint32_t record = no_record; ///< its node in the output; no_record for a subtree's root
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::array<std::int32_t, 3> center = {}; ///< grid steps from the subtree's lower corner
};

/// Cells of one depth with their pairs; arrays are padded for the vector lanes.
struct SplitLevel {
    GrowBuffer<SplitCell> cells;
    GrowBuffer<std::uint32_t> triangle; ///< index within the subtree
    std::array<GrowBuffer<std::int32_t>, 3> center;
    std::size_t pair_count = 0;

    /// Empties the level and reserves capacity for pairs and padding.
    void reset(std::size_t pair_capacity);
    /// Zeroes the padding behind the last pair.
    void pad();
    [[nodiscard]] SnappedPairs pairs() const noexcept;
};

/// Where nodes and references go; offsets are relative to these arrays.
struct OctreeOutput {
    GrowBuffer<OctreeNode> nodes;
    GrowBuffer<TriangleId> references;
};

/// Bytes that the output holds, unused capacity included.
[[nodiscard]] inline std::uint64_t bytes(const OctreeOutput& output) noexcept
{
    return output.nodes.capacity() * sizeof(OctreeNode) +
           output.references.capacity() * sizeof(TriangleId);
}

/// What decides whether a child is split again.
struct SplitRule {
    std::uint32_t threshold = 0;
    bool children_are_deepest = false;
    std::int32_t child_half = 0; ///< half size of the children, in grid steps
};

/// Reads level.cells and masks[pair] (bit = octant touched; child_count bits in all); writes the
/// children's nodes and the leaves' references (ids[triangle]) to the output, the children to split
/// to `next`, and each cell's own node to its record, or to `root` where it has none. Triangles
/// keep their order.
void distribute_children(const SplitLevel& level, const std::uint32_t* masks,
                         std::uint64_t child_count, const std::uint32_t* ids, const SplitRule& rule,
                         SplitLevel& next, OctreeOutput& output, OctreeNode& root);

/// How many (triangle, child) pairs the masks of `count` pairs stand for. \pre padded
[[nodiscard]] std::uint64_t count_children(const std::uint32_t* masks, std::size_t count) noexcept;

} // namespace proxima
