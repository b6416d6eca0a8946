#include "index/lists/proximity_lists.h"

#include <utility>

namespace proxima {

std::uint64_t ProximityLists::bytes() const noexcept
{
    return arrays_.table.size_bytes() + arrays_.nodes.size_bytes() + arrays_.runs.size_bytes() +
           arrays_.arena.size_bytes();
}

ProximityLists ProximityLists::adopt(const RootFrame& frame, int table_depth,
                                     const ProximityArrays& arrays,
                                     const ProximityStatistics& statistics,
                                     std::shared_ptr<const void> storage,
                                     std::shared_ptr<const void> shared_storage) noexcept
{
    ProximityLists lists;
    lists.frame_ = frame;
    lists.grid_scale_ = static_cast<double>(1U << (location_bits - 1)) / frame.frame_half();
    lists.table_depth_ = table_depth;
    lists.arrays_ = arrays;
    lists.statistics_ = statistics;
    lists.shared_storage_ = shared_storage != nullptr ? std::move(shared_storage) : storage;
    lists.storage_ = std::move(storage);
    return lists;
}

} // namespace proxima
