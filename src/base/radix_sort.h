// Sorting of integer keys with a payload in linear time.
#pragma once

#include "base/progress.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace proxima {

/// A key and what belongs to it.
struct KeyedIndex {
    std::uint64_t key = 0;
    std::uint32_t index = 0;
};

inline constexpr unsigned radix_digit_bits = 11;

/// How often the items are passed over to sort keys of so many bits.
[[nodiscard]] constexpr unsigned radix_passes(unsigned key_bits) noexcept
{
    return (key_bits + radix_digit_bits - 1) / radix_digit_bits;
}

/// Sorts by the lowest `key_bits` bits of key_of(item), ascending and stable; the bits above must
/// be zero. A step per item and pass. O(items * key_bits / 11), one copy of the items as scratch.
/// False, with the items in no order, where `steps` asks to stop.
template <class Item, class KeyOf>
[[nodiscard]] bool radix_sort(std::vector<Item>& items, unsigned key_bits, const KeyOf& key_of,
                              StageSteps& steps)
{
    constexpr std::uint64_t digit_mask = (1U << radix_digit_bits) - 1;
    std::vector<Item> other(items.size());
    for (unsigned shift = 0; shift < key_bits; shift += radix_digit_bits) {
        std::array<std::size_t, digit_mask + 1> starts{};
        for (const Item& item : items) ++starts[key_of(item) >> shift & digit_mask];
        std::size_t sum = 0;
        for (std::size_t& start : starts) sum += std::exchange(start, sum);
        for (const Item& item : items) {
            other[starts[key_of(item) >> shift & digit_mask]++] = item;
            if (!steps.done(1)) return false;
        }
        items.swap(other);
    }
    return true;
}

/// The same for keys with a payload.
[[nodiscard]] inline bool radix_sort(std::vector<KeyedIndex>& items, unsigned key_bits,
                                     StageSteps& steps)
{
    return radix_sort(
        items, key_bits, [](const KeyedIndex& item) { return item.key; }, steps);
}

} // namespace proxima
