// Whether the blocks of the arena of closest-feature lists are sound, and which of them leaves name.
#pragma once

#include "index/check_work.h"
#include "proxima/result.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// A byte of scratch per eight of the arena. Positions are in units of block_alignment.
class ArenaChecker {
public:
    ArenaChecker(std::span<const std::byte> arena, std::uint64_t rows);

    /// Whether the arena is blocks one behind the other, zeros between, indices of vertices and
    /// ranks in range. Error broken_invariant; cancelled.
    [[nodiscard]] Status check_blocks(const CheckWork& work);

    /// How many triangles of a block there a leaf names: 1 to 16 that the block has; 0 where it may
    /// not. Thread safe. \pre check_blocks found nothing
    [[nodiscard]] std::uint32_t use(std::uint32_t position, std::uint32_t mask) noexcept;

    [[nodiscard]] std::uint64_t blocks() const noexcept { return blocks_; }

    /// Whether leaves named every block. O(arena).
    [[nodiscard]] bool all_used() const noexcept;

private:
    /// From block to block by their headers; `tasks_` gets some of their beginnings.
    Status walk_headers(const CheckWork& work);
    [[nodiscard]] Status check_contents(std::size_t task) const;

    std::span<const std::byte> arena_;
    std::uint64_t rows_;
    std::vector<std::atomic<std::uint8_t>> states_; ///< triangles of the block there, used_bit
    std::vector<std::size_t> tasks_;                ///< ends with the end of the last block
    std::uint64_t blocks_ = 0;
};

} // namespace proxima
