#include "index/index_parts.h"

#include "index/slabs/block_slab.h"

#include <algorithm>
#include <utility>

namespace proxima {

namespace {

/// Some box where the arrays come from a damaged file, which is refused only later.
RootBox root_box_of(const IndexArrays& arrays) noexcept
{
    RootBox box;
    box.lower.fill(-1 - RootBox::margin);
    box.upper.fill(1 + RootBox::margin);
    const std::uint32_t block = arrays.root & ~index_leaf_bit;
    if ((arrays.root & index_leaf_bit) != 0 || block >= arrays.blocks.size()) return box;
    const IndexNode& root = arrays.blocks[block].node;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        double lower = 1;
        double upper = -1;
        for (std::size_t slot = 0; slot < 8; ++slot) {
            if (!root.has_child(slot)) continue;
            lower = std::min(lower, root.plane(axis, slot));
            upper = std::max(upper, root.plane(axis, 8 + slot));
        }
        box.lower[axis] = std::max(lower, -1.0) - RootBox::margin;
        box.upper[axis] = std::min(upper, 1.0) + RootBox::margin;
    }
    return box;
}

} // namespace

IndexParts IndexParts::adopt(const IndexArrays& arrays,
                             std::shared_ptr<const void> storage) noexcept
{
    IndexParts parts;
    parts.arrays_ = arrays;
    parts.unscale_ = 1 / arrays.scale;
    parts.root_box_ = root_box_of(arrays);
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

double block_unit(const IndexParts& index) noexcept
{
    const Vec3 first = index.triangle(0)[0];
    for (std::uint32_t row = 0; row < index.triangle_count(); ++row) {
        for (const Vec3& corner : index.triangle(row).vertices)
            if (corner != first) return index.unscale();
    }
    return 0;
}

} // namespace proxima
