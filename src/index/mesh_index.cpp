#include "index/mesh_index.h"

#include "index/lists/proximity_lists.h"
#include "index/slabs/block_slab.h"

#include <utility>

namespace proxima {

MeshIndex MeshIndex::adopt(const MeshIndexParts& parts,
                           std::shared_ptr<const void> storage) noexcept
{
    MeshIndex index;
    index.parts_ = parts;
    index.unscale_ = 1 / parts.scale;
    index.storage_ = std::move(storage);
    return index;
}

MeshIndex MeshIndex::adopt_lists(std::shared_ptr<const ProximityLists> lists) const noexcept
{
    MeshIndex index = *this;
    index.lists_ = std::move(lists);
    return index;
}

MeshIndex MeshIndex::adopt_slabs(std::span<const BlockSlab> slabs,
                                 std::shared_ptr<const void> storage) const noexcept
{
    MeshIndex index = *this;
    index.slabs_ = slabs;
    index.slab_storage_ = std::move(storage);
    return index;
}

std::uint64_t MeshIndex::bytes() const noexcept
{
    const MeshIndexBytes bytes = bytes_of(*this);
    return bytes.blocks + bytes.rows + bytes.ids + bytes.places + bytes.lists + bytes.slabs;
}

MeshIndexBytes bytes_of(const MeshIndex& index) noexcept
{
    MeshIndexBytes bytes;
    bytes.blocks = index.blocks().size_bytes();
    bytes.rows = index.float_rows().size_bytes() + index.double_rows().size_bytes();
    bytes.ids = index.ids().size_bytes();
    bytes.places = index.vertex_places().size_bytes() + index.edge_places().size_bytes();
    bytes.lists = index.lists() != nullptr ? index.lists()->bytes() : 0;
    bytes.slabs = index.slabs().size_bytes();
    return bytes;
}

} // namespace proxima
