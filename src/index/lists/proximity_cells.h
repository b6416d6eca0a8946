// The cells of closest-feature lists from the root down. Queries begin at the table; checks and
// exports want the levels above it as well.
#pragma once

#include "index/lists/proximity_lists.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// The word of the root: its children are the only eight nodes that no other cell names. Where
/// there are no nodes it is the table's. Error broken_invariant naming the node, where children
/// are not eight nodes of the array, or are named twice, or there is not one such group. For any
/// content of the arrays. O(nodes), a bit of scratch per eight.
[[nodiscard]] Result<std::uint64_t> root_word(const ProximityArrays& arrays);

/// A cell with its place.
struct ProximityCell {
    std::uint64_t word = 0;
    int depth = 0;
    std::array<std::uint32_t, 3> at{}; ///< in [0, 2^depth)
};

/// \pre the cell is split; bits 0, 1, 2 of the octant are the upper halves of x, y, z
[[nodiscard]] inline ProximityCell child(const ProximityArrays& arrays, const ProximityCell& cell,
                                         std::uint32_t octant) noexcept
{
    return {arrays.nodes[cell.word + octant],
            cell.depth + 1,
            {2 * cell.at[0] + (octant & 1U), 2 * cell.at[1] + (octant >> 1U & 1U),
             2 * cell.at[2] + (octant >> 2U)}};
}

/// The words of all cells of a level: of the cell, or of the leaf that holds it. `root` is the
/// root's word. \pre 8^depth words of table
void fill_table(std::uint64_t root, std::span<const std::uint64_t> nodes, int depth,
                std::span<std::uint64_t> table) noexcept;

/// Triangles in a leaf's list; 0 for a leaf without one. \pre the arrays are sound
[[nodiscard]] std::uint32_t list_length(const ProximityArrays& arrays, std::uint64_t leaf) noexcept;

/// The ranks of the triangles in a leaf's list, into `ranks`, in no particular order.
/// \pre the arrays are sound
void read_list(const ProximityArrays& arrays, std::uint64_t leaf,
               std::vector<std::uint32_t>& ranks);

/// As triangles, as far as the span goes; returns how many there are. `ids` are those of the index's
/// rows. No allocation.
std::size_t read_list(const ProximityArrays& arrays, std::span<const TriangleId> ids,
                      std::uint64_t leaf, std::span<TriangleId> triangles) noexcept;

} // namespace proxima
