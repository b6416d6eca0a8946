#include "index/index_parts.h"

#include "index/slabs/block_slab.h"

#include <utility>

namespace proxima {

IndexParts IndexParts::adopt(const IndexArrays& arrays,
                             std::shared_ptr<const void> storage) noexcept
{
    IndexParts parts;
    parts.arrays_ = arrays;
    parts.unscale_ = 1 / arrays.scale;
    parts.storage_ = std::move(storage);
    return parts;
}

IndexParts IndexParts::adopt_lists(std::shared_ptr<const ProximityLists> lists) const noexcept
{
    IndexParts parts = *this;
    parts.lists_ = std::move(lists);
    return parts;
}

IndexParts IndexParts::adopt_slabs(std::span<const BlockSlab> slabs,
                                   std::shared_ptr<const void> storage) const noexcept
{
    IndexParts parts = *this;
    parts.slabs_ = slabs;
    parts.slab_storage_ = std::move(storage);
    return parts;
}

IndexParts IndexParts::adopt_signs(std::shared_ptr<const SignParts> signs) const noexcept
{
    IndexParts parts = *this;
    parts.signs_ = std::move(signs);
    return parts;
}

} // namespace proxima
