// Finds equal items among many in linear time, by a hash table of their numbers.
#pragma once

#include <bit>
#include <cstdint>
#include <numeric>
#include <vector>

namespace proxima {

/// Scatters all bits of `value` over the result, and `seed` with it: build hashes of several
/// numbers by passing the hash so far as the seed.
[[nodiscard]] constexpr std::uint64_t mix_bits(std::uint64_t seed, std::uint64_t value) noexcept
{
    std::uint64_t bits = seed ^ value * 0x9E3779B97F4A7C15U;
    bits = (bits ^ bits >> 32U) * 0xD6E8FEB86659FD93U;
    bits = (bits ^ bits >> 32U) * 0xD6E8FEB86659FD93U;
    return bits ^ bits >> 32U;
}

/// For every item in [0, count) the first item equal to it, itself where there is none before.
/// `takes_part(i)` leaves items out: each of them is only equal to itself. `hash(i)` must be the
/// same for equal items, `equal(i, j)` an equivalence. Expected O(count), 12 to 20 bytes per item.
/// \pre count < 2^32 - 1
template <class TakesPart, class Hash, class Equal>
[[nodiscard]] std::vector<std::uint32_t> first_equal_items(std::uint32_t count,
                                                           const TakesPart& takes_part,
                                                           const Hash& hash, const Equal& equal)
{
    constexpr std::uint32_t free_slot = ~std::uint32_t{0};
    std::vector<std::uint32_t> first(count);
    std::iota(first.begin(), first.end(), 0U);
    const std::uint64_t mask = std::bit_ceil(std::uint64_t{2} * count + 1) - 1;
    std::vector<std::uint32_t> slots(mask + 1, free_slot);
    for (std::uint32_t item = 0; item < count; ++item) {
        if (!takes_part(item)) continue;
        std::uint64_t slot = hash(item) & mask;
        while (slots[slot] != free_slot && !equal(slots[slot], item)) slot = (slot + 1) & mask;
        if (slots[slot] == free_slot) slots[slot] = item;
        first[item] = slots[slot];
    }
    return first;
}

} // namespace proxima
