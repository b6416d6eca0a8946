#include "index/lists/proximity_octree.h"

#include <utility>

namespace proxima {

std::uint64_t ProximityOctree::bytes() const noexcept
{
    return arrays_.table.size_bytes() + arrays_.nodes.size_bytes() + arrays_.runs.size_bytes() +
           arrays_.arena.size_bytes() + arrays_.float_rows.size_bytes() +
           arrays_.double_rows.size_bytes() + arrays_.vertex_places.size_bytes() +
           arrays_.edge_places.size_bytes() + tree_->bytes();
}

ProximityOctree ProximityOctree::adopt(const RootFrame& frame, int table_depth,
                                       const ProximityArrays& arrays, const TriangleTree* tree,
                                       const ProximityStatistics& statistics,
                                       std::uint64_t fingerprint,
                                       std::shared_ptr<const void> storage) noexcept
{
    ProximityOctree octree;
    octree.frame_ = frame;
    octree.grid_scale_ = static_cast<double>(1U << (location_bits - 1)) / frame.frame_half();
    octree.table_depth_ = table_depth;
    octree.arrays_ = arrays;
    octree.tree_ = tree;
    octree.statistics_ = statistics;
    octree.fingerprint_ = fingerprint;
    octree.storage_ = std::move(storage);
    return octree;
}

} // namespace proxima
