// One tree of cut cells as words and blocks, with positions of its own.
#pragma once

#include "index/lists/grow_cells.h"
#include "index/lists/proximity_lists.h"
#include "index/lists/rank_blocks.h"
#include "index/lists/shared_blocks.h"
#include "proxima/octree.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// In a tree on its own: a run's block is one of the blocks by rank, which all trees share.
inline constexpr std::uint32_t by_rank_bit = 1U << 31U;

/// A tree with positions of its own: nodes and runs count from its own beginning, blocks by number.
struct EmittedTree {
    std::uint64_t root = 0;
    std::vector<std::uint64_t> nodes;
    std::vector<RunEntry> runs;
    std::vector<std::size_t> positions; ///< of blocks in the arena
    std::vector<std::byte> arena;
    ProximityStatistics statistics;
};

/// Emits one tree after the other.
class TreeEmitter {
public:
    TreeEmitter(const BlockSource& source, const RankBlocks& by_rank, double frame_half);

    /// From its first cell down.
    EmittedTree emit(const GrownTree& tree);

    /// The word of a leaf of the top, into a tree of its own.
    EmittedTree emit_leaf(const GrownTree& tree, std::size_t cell, CellKey key);

private:
    /// Of a list: a block by rank and what it has of it, entries begin to end.
    struct RankPart {
        std::uint32_t block = 0;
        std::uint32_t mask = 0;
        std::size_t begin = 0;
        std::size_t end = 0;
    };

    void begin(const GrownTree& tree);
    EmittedTree take_result(std::uint64_t root);
    std::uint64_t word_of(const GrownCell& cell, CellKey key);
    std::uint64_t leaf_word(const GrownCell& cell, CellKey key);
    void count_leaf(const GrownCell& cell, CellKey key);

    /// Where the list's chunks begin, each small enough for a block, and where the last one ends.
    void split_list();

    std::uint32_t add_run(CellKey key);

    /// The list's parts by the blocks of their ranks.
    void find_blocks_by_rank();

    [[nodiscard]] Vec3 center_of(CellKey key) const;

    /// A lower bound on distances from about the cell's centre.
    [[nodiscard]] RunEntry bound(std::span<const std::uint32_t> chunk, const Vec3& center) const;

    BlockSource source_;
    const RankBlocks& by_rank_;
    double frame_half_;
    BlockSharer sharer_;
    const GrownTree* tree_ = nullptr;
    EmittedTree result_;
    std::vector<std::uint32_t> ranks_;
    std::vector<std::size_t> chunks_;
    std::vector<RankPart> parts_;
};

} // namespace proxima
