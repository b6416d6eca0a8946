// What a mesh index that was built owns.
#pragma once

#include "base/grow_buffer.h"
#include "index/mesh_index.h"
#include "index/row_tables.h"

#include <cstring>
#include <memory>
#include <span>
#include <vector>

namespace proxima {

/// Blocks are on huge pages where the system has them: rays jump about in them.
struct IndexStorage {
    GrowBuffer<std::byte> memory; ///< of the blocks, with what aligning them takes
    std::span<const IndexBlock> blocks;
    RowTables tables;
    std::vector<TriangleId> ids;

    void take(std::span<const IndexBlock> made)
    {
        memory.resize(made.size_bytes() + alignof(IndexBlock));
        void* first = memory.data();
        std::size_t room = memory.size();
        first = std::align(alignof(IndexBlock), made.size_bytes(), first, room);
        std::memcpy(first, made.data(), made.size_bytes());
        blocks = {static_cast<const IndexBlock*>(first), made.size()};
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
