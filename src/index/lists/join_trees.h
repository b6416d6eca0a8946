// Joins trees that were emitted on their own into the arrays of one octree.
#pragma once

#include "index/lists/emit_lists.h"
#include "index/lists/emit_tree.h"
#include "index/lists/rank_blocks.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// Where a tree's arrays begin within the octree's.
struct TreePlace {
    std::size_t first_node = 0;
    std::size_t first_run = 0;
    std::size_t first_byte = 0; ///< of the arena, a multiple of block_alignment
};

/// A word of the tree as the octree has it; a wrong one of the same kind where the place is beyond
/// what words can name.
[[nodiscard]] std::uint64_t moved_word(std::uint64_t word, const EmittedTree& tree,
                                       const TreePlace& place) noexcept;

/// Joins trees into one.
class OctreeJoiner {
public:
    /// Capacity for all at once: what moves while it grows loses its huge pages.
    OctreeJoiner(EmittedLists& octree, std::span<const EmittedTree> trees,
                 const RankBlocks& by_rank);

    /// Copies the tree's arrays to the end. Returns the word of its root. Words are wrong once there is
    /// more than they can name: EmittedLists::part_of tells.
    std::uint64_t join(const EmittedTree& tree);

private:
    static constexpr std::size_t usual_block_bytes = 384;

    /// Written when it is first met.
    std::uint32_t block_by_rank(std::uint32_t block);

    [[nodiscard]] std::size_t aligned_end() const;
    void append_bytes(std::size_t first_byte, std::span<const std::byte> bytes);
    void count(const ProximityStatistics& more);

    static constexpr std::uint32_t no_position = 0xFFFFFFFF;

    EmittedLists& octree_;
    const RankBlocks& by_rank_;
    std::vector<std::uint32_t> positions_by_rank_; ///< in the arena
    std::vector<std::byte> bytes_;
};

} // namespace proxima
