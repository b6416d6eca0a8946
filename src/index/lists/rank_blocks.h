// Blocks of consecutive triangles in the order of ranks, each triangle in one of them: what long
// lists are made of. A list names few of them, and neighbouring leaves name the same ones, so that
// a long list takes little more than its masks.
#pragma once

#include "index/lists/shared_blocks.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

/// Where ranks are cut into blocks. Immutable.
class RankBlocks {
public:
    /// As many ranks to a block as its triangles and vertices allow. O(triangles).
    explicit RankBlocks(const BlockSource& source);

    /// The block that holds a rank, and the first rank in it.
    struct Location {
        std::uint32_t block = 0;
        std::uint32_t first = 0;
    };
    [[nodiscard]] Location location(std::uint32_t rank) const noexcept
    {
        const std::uint32_t block = block_of_[rank];
        return {block, firsts_[block]};
    }

    /// Blocks.
    [[nodiscard]] std::size_t size() const noexcept { return firsts_.size() - 1; }

    /// Writes one, returns where it begins. Bit i of a mask is its rank first + i.
    std::size_t append(std::uint32_t block, std::vector<std::byte>& arena) const;

private:
    BlockSource source_;
    std::vector<std::uint32_t> block_of_; ///< per rank
    std::vector<std::uint32_t> firsts_;   ///< ranks, and their end
};

} // namespace proxima
