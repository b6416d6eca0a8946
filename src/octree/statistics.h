// Counts of an octree's cells and lists: the columns of the thesis's tables 2.1 to 2.3.
#pragma once

#include "octree/octree.h"

#include <array>
#include <cstdint>

namespace proxima {

/// What `octree_statistics` counts. Cells include empty leaves that have no record.
struct OctreeStatistics {
    std::uint64_t total = 0; ///< all cells: 8 per split cell, and the root
    std::uint64_t leaves = 0;
    std::uint64_t occupied_leaves = 0; ///< leaves that some triangle touches
    double occupied_percent = 0.0;     ///< occupied leaves per 100 leaves

    std::uint32_t min_triangles = 0; ///< shortest list of an occupied leaf
    std::uint32_t max_triangles = 0; ///< longest list
    std::uint64_t references = 0;    ///< sum of all lists: the thesis's Pointers

    // Lengths of lists; "std" is the standard deviation of the whole population (divided by its
    // size), so a tree of one leaf has 0.
    double mean_triangles = 0.0;  ///< over occupied leaves
    double std_triangles = 0.0;   ///< over occupied leaves
    double mean_all_leaves = 0.0; ///< over all leaves, as in the thesis's table 2.3
    double std_all_leaves = 0.0;  ///< over all leaves

    // Leaves by class.
    std::uint64_t inner = 0;
    std::uint64_t outer = 0;
    std::uint64_t boundary = 0;
    std::uint64_t unclassified = 0;

    int depth_reached = 0;   ///< depth of the deepest cell
    std::uint64_t bytes = 0; ///< Octree::bytes()
    std::array<std::uint64_t, max_octree_depth + 1> leaves_at_depth{};
};

/// Counts once through the octree. Sums are exact integers, so the figures have the same bits on
/// every machine. O(cells), no allocation, thread safe.
[[nodiscard]] OctreeStatistics octree_statistics(const Octree& octree) noexcept;

} // namespace proxima
