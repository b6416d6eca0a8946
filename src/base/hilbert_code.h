// The position of a cell on Hilbert's curve through a cube: cells that follow each other share a side,
// so that runs of the order are more compact than those of Morton codes. Every run of 8^n codes
// that starts at a multiple of it fills a cube, as Morton's do. J. Skilling's transform
// [skilling-2004].
#pragma once

#include "base/morton_code.h"

#include <array>
#include <cstdint>

namespace proxima {

/// The code of coordinates, each below 2^bits: 3 bits of code per bit. \pre 0 < bits <= morton_bits
[[nodiscard]] constexpr std::uint64_t hilbert_code(std::array<std::uint32_t, 3> at,
                                                   int bits) noexcept
{
    // Undo the turns of the curve, from the whole cube to the smallest. No branches: half of them
    // would be mispredicted.
    for (int k = bits - 1; k > 0; --k) {
        const std::uint32_t below = (std::uint32_t{1} << k) - 1;
        for (std::uint32_t& coordinate : at) {
            const std::uint32_t flipped = (0U - (coordinate >> k & 1U)) & below;
            const std::uint32_t swapped = (at[0] ^ coordinate) & (flipped ^ below);
            at[0] ^= flipped | swapped;
            coordinate ^= swapped;
        }
    }
    // What is left is a Gray code.
    at[1] ^= at[0];
    at[2] ^= at[1];
    std::uint32_t flips = at[2] >> 1U;
    for (const unsigned shift : {1U, 2U, 4U, 8U, 16U}) flips ^= flips >> shift;
    for (std::uint32_t& coordinate : at) coordinate ^= flips;
    return morton_code({at[2], at[1], at[0]});
}

} // namespace proxima
