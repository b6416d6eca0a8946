// Stable orders of many items by whole numbers.
#pragma once

#include "base/radix_sort.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// Keys and positions of the items 0 to count - 1, ascending by key_of(i); equal ones keep their
/// order. Linear time. Throws std::bad_alloc. \pre count < 2^32
template <class KeyOf>
[[nodiscard]] std::vector<KeyedIndex> order_by_key(std::size_t count, const KeyOf& key_of)
{
    std::vector<KeyedIndex> order(count);
    std::uint64_t most = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        order[i] = {key_of(i), i};
        most = std::max(most, order[i].key);
    }
    StageSteps unwatched(nullptr, "", 0);
    (void)radix_sort(order, static_cast<unsigned>(std::bit_width(most)), unwatched);
    return order;
}

/// Calls visit(group) for each run of equal keys.
template <class Visit>
void each_group(std::span<const KeyedIndex> order, const Visit& visit)
{
    for (std::size_t first = 0; first < order.size();) {
        std::size_t end = first + 1;
        while (end < order.size() && order[first].key == order[end].key) ++end;
        visit(order.subspan(first, end - first));
        first = end;
    }
}

} // namespace proxima
