// The few levels above the coarse bins: which of their cells are split, and where subtrees hang.
#pragma once

#include "octree/coarse_bins.h"
#include "octree/distribute_children.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// A coarse cell whose subtree is still to be grown.
struct SubtreeSlot {
    std::uint32_t cell = 0;   ///< Morton index among the coarse cells
    std::uint32_t record = 0; ///< its node among the top nodes
};

/// Appends the nodes above and of the coarse cells to the empty output, breadth first, and the
/// references of leaves above them. A cell overlaps a triangle iff a coarse cell below it does, so
/// no test is made. Returns the coarse cells in Morton order.
[[nodiscard]] std::vector<SubtreeSlot>
build_top_tree(const CoarseBins& bins, std::uint32_t threshold, OctreeOutput& output);

} // namespace proxima
