// What a mesh index that was built owns.
#pragma once

#include "base/grow_buffer.h"
#include "index/mesh_index.h"
#include "index/row_tables.h"

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
        memory.resize((count + 1) * sizeof(IndexBlock));
        void* first = memory.data();
        std::size_t space = memory.size();
        first = std::align(alignof(IndexBlock), count * sizeof(IndexBlock), first, space);
        return blocks = {static_cast<IndexBlock*>(first), count};
    }
};

/// The index of what is stored; frame, root and fingerprint are those of `parts`.
[[nodiscard]] inline MeshIndex index_of(MeshIndexParts parts, IndexStorage stored)
{
    auto storage = std::make_shared<const IndexStorage>(std::move(stored));
    parts.blocks = storage->blocks;
    parts.float_rows = storage->tables.float_rows.span();
    parts.double_rows = storage->tables.double_rows.span();
    parts.ids = storage->ids;
    parts.vertex_places = storage->tables.vertex_places.span();
    parts.edge_places = storage->tables.edge_places.span();
    return MeshIndex::adopt(parts, std::move(storage));
}

} // namespace proxima
