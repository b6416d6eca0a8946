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
    const std::uint32_t top = std::uint32_t{1} << (bits - 1);
    // Undo the turns of the curve, from the whole cube to the smallest.
    for (std::uint32_t bit = top; bit > 1; bit >>= 1U) {
        const std::uint32_t below = bit - 1;
        for (std::uint32_t& coordinate : at) {
            if ((coordinate & bit) != 0) {
                at[0] ^= below;
            } else {
                const std::uint32_t swapped = (at[0] ^ coordinate) & below;
                at[0] ^= swapped;
                coordinate ^= swapped;
            }
        }
    }
    // What is left is a Gray code.
    at[1] ^= at[0];
    at[2] ^= at[1];
    std::uint32_t flips = 0;
    for (std::uint32_t bit = top; bit > 1; bit >>= 1U) {
        if ((at[2] & bit) != 0) flips ^= bit - 1;
    }
    for (std::uint32_t& coordinate : at) coordinate ^= flips;
    return morton_code({at[2], at[1], at[0]});
}

} // namespace proxima
