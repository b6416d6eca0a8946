// Turns cut cells into the words and blocks of closest-feature lists.
#pragma once

#include "base/grow_buffer.h"
#include "index/lists/grow_cells.h"
#include "index/lists/proximity_lists.h"
#include "index/lists/shared_blocks.h"
#include "proxima/execution.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace proxima {

/// Parts of the blocks or the runs that words can name, whichever is more.
[[nodiscard]] double part_of_words(std::size_t arena_bytes, std::size_t runs) noexcept;

/// The arrays of ProximityLists.
struct EmittedLists {
    GrowBuffer<std::uint64_t> table;
    GrowBuffer<std::uint64_t> nodes;
    GrowBuffer<RunEntry> runs;
    GrowBuffer<std::byte> arena;
    int table_depth = 0;
    ProximityStatistics statistics;

    [[nodiscard]] std::uint64_t bytes() const noexcept;

    /// Parts of so many bytes that it takes, or of the blocks and runs that words can name, whichever is
    /// more: where it is above 1, words may be wrong.
    [[nodiscard]] double part_of(double most_bytes) const noexcept;
};

struct EmitOptions {
    double frame_half = 1;
    Execution execution = {};
};

/// Of a forest that was cut. Null where cancelled. The same for any number of threads. About 1 us
/// per leaf.
[[nodiscard]] std::optional<EmittedLists>
emit_lists(const GrownForest& forest, const BlockSource& source, const EmitOptions& options);

/// Bytes that the trees take as nodes, runs and blocks of their own: without the blocks by rank
/// (rank_blocks.h), which are once for all. Null where cancelled.
[[nodiscard]] std::optional<double> emitted_bytes(std::span<const GrownTree> trees,
                                                  const BlockSource& source,
                                                  const EmitOptions& options);

} // namespace proxima
