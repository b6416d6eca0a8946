#include "proxima/mesh_index.h"

#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "index/signs/sign_parts.h"
#include "index/slabs/block_slab.h"

#include <utility>

namespace proxima {

MeshIndex::MeshIndex()
{
    static const auto empty = std::make_shared<const IndexParts>();
    parts_ = empty;
}

MeshIndex::MeshIndex(std::shared_ptr<const IndexParts> parts) noexcept : parts_(std::move(parts)) {}

std::uint32_t MeshIndex::triangle_count() const noexcept
{
    return parts_->triangle_count();
}

std::size_t MeshIndex::vertex_count() const noexcept
{
    return parts_->vertex_count();
}

std::size_t MeshIndex::edge_count() const noexcept
{
    return parts_->edge_count();
}

std::uint64_t MeshIndex::bytes() const noexcept
{
    const MeshIndexBytes bytes = bytes_of(*this);
    return bytes.blocks + bytes.rows + bytes.ids + bytes.incidences + bytes.lists + bytes.slabs +
           bytes.signs;
}

bool MeshIndex::has_lists() const noexcept
{
    return parts_->lists() != nullptr;
}

bool MeshIndex::has_slabs() const noexcept
{
    return !parts_->slabs().empty();
}

bool MeshIndex::has_signs() const noexcept
{
    return parts_->signs() != nullptr;
}

std::uint64_t MeshIndex::mesh_fingerprint() const noexcept
{
    return parts_->mesh_fingerprint();
}

std::span<const TriangleId> MeshIndex::ids() const noexcept
{
    return parts_->ids();
}

MeshIndexBytes bytes_of(const MeshIndex& index) noexcept
{
    const IndexParts& parts = index.parts();
    MeshIndexBytes bytes;
    bytes.blocks = parts.blocks().size_bytes();
    bytes.rows = parts.float_rows().size_bytes() + parts.double_rows().size_bytes();
    bytes.ids = parts.ids().size_bytes();
    bytes.incidences =
        parts.vertex_incidences().size_bytes() + parts.edge_incidences().size_bytes();
    bytes.lists = parts.lists() != nullptr ? parts.lists()->bytes() : 0;
    bytes.slabs = parts.slabs().size_bytes();
    bytes.signs = parts.signs() != nullptr ? parts.signs()->bytes() : 0;
    return bytes;
}

} // namespace proxima
