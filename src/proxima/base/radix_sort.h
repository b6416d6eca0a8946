// Sorting of integer keys with a payload in linear time.
#pragma once

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

/// Sorts by the lowest `key_bits` bits of the keys, ascending and stable; the bits above must be
/// zero. O(items * key_bits / 11), one copy of the items as scratch.
inline void radix_sort(std::vector<KeyedIndex>& items, unsigned key_bits)
{
    constexpr unsigned digit_bits = 11;
    constexpr std::uint64_t digit_mask = (1U << digit_bits) - 1;
    std::vector<KeyedIndex> other(items.size());
    for (unsigned shift = 0; shift < key_bits; shift += digit_bits) {
        std::array<std::size_t, digit_mask + 1> place{};
        for (const KeyedIndex& item : items) ++place[item.key >> shift & digit_mask];
        std::size_t sum = 0;
        for (std::size_t& start : place) sum += std::exchange(start, sum);
        for (const KeyedIndex& item : items) other[place[item.key >> shift & digit_mask]++] = item;
        items.swap(other);
    }
}

} // namespace proxima
