// What a mesh index that was built owns.
#pragma once

#include "base/grow_buffer.h"
#include "index/index_parts.h"
#include "index/row_tables.h"
#include "proxima/mesh_index.h"

#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace proxima {

/// Blocks are on huge pages where the system has them: queries jump about in them.
struct IndexStorage {
    GrowBuffer<std::byte> memory; ///< of the blocks, and what aligning them takes
    std::span<IndexBlock> blocks;
    RowTables tables;
    std::vector<TriangleId> ids;

    /// Blocks with whatever the memory holds.
    std::span<IndexBlock> make_blocks(std::size_t count)
    {
        std::byte* const first =
            aligned_bytes(memory, count * sizeof(IndexBlock), alignof(IndexBlock));
        return blocks = {static_cast<IndexBlock*>(static_cast<void*>(first)), count};
    }
};

/// The parts of what is stored; frame, root and fingerprint are those of `arrays`.
[[nodiscard]] inline IndexParts index_of(IndexArrays arrays, IndexStorage stored)
{
    auto storage = std::make_shared<const IndexStorage>(std::move(stored));
    arrays.blocks = storage->blocks;
    arrays.float_rows = storage->tables.float_rows.span();
    arrays.double_rows = storage->tables.double_rows.span();
    arrays.ids = storage->ids;
    arrays.vertex_incidences = storage->tables.vertex_incidences.span();
    arrays.edge_incidences = storage->tables.edge_incidences.span();
    return IndexParts::adopt(arrays, std::move(storage));
}

} // namespace proxima
