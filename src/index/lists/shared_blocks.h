// Blocks that leaves share: neighbouring leaves list much the same triangles.
//
// Leaves come along the Morton curve. A list joins the open block that grows least, if at least a
// third of the list is there already and the union fits one block; otherwise it opens a block, and
// the one not used for longest is closed and written.
#pragma once

#include "index/lists/block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// What blocks are made from.
struct BlockSource {
    std::span<const Vec3> positions;                         ///< in the root's frame
    std::span<const std::array<std::uint32_t, 3>> triangles; ///< vertices by rank
};

/// Puts lists into blocks. Keeps its memory for the next arena.
class BlockSharer {
public:
    explicit BlockSharer(const BlockSource& source)
        : source_(source), open_of_(source.triangles.size())
    {}

    /// Starts an arena.
    void begin();

    /// Where triangles are.
    struct Location {
        std::uint32_t number = 0; ///< of the block
        std::uint32_t mask = 0;   ///< bit i: the block's triangle i is one of them
    };

    /// The block that holds these triangles from now on. \pre 1 to 16 distinct ranks,
    /// at most 32 vertices
    Location put(std::span<const std::uint32_t> ranks);

    /// Writes all that is open. Block number i then begins at positions()[i] in arena().
    void end();

    [[nodiscard]] const std::vector<std::size_t>& positions() const noexcept { return positions_; }
    [[nodiscard]] std::vector<std::byte>& arena() noexcept { return arena_; }

private:
    static constexpr std::size_t open_blocks = 64;

    struct OpenBlock {
        std::array<std::uint32_t, block_triangles> ranks{};
        std::array<std::uint32_t, block_vertices> vertices{};
        std::size_t rank_count = 0;
        std::size_t vertex_count = 0;
        std::uint32_t number = 0;
        std::uint64_t last_use = 0;
    };

    [[nodiscard]] bool join(OpenBlock& block, std::uint64_t bit,
                            std::span<const std::uint32_t> ranks);
    [[nodiscard]] static Location location_in(const OpenBlock& block,
                                              std::span<const std::uint32_t> ranks);
    void write(OpenBlock& block, std::uint64_t bit);

    BlockSource source_;
    std::vector<std::uint64_t> open_of_; ///< per rank: bit i = it is in open block i
    std::array<OpenBlock, open_blocks> blocks_;
    std::vector<std::size_t> positions_;
    std::vector<std::byte> arena_;
    std::uint64_t clock_ = 0;
};

} // namespace proxima
