// Numbers whose bits take turns: neighbours in space get numbers that are near each other.
//
//     x  a b c
//     y   d e f      ->   g d a h e b i f c   (x lowest)
//     z    g h i
#pragma once

#include <array>
#include <cstdint>

namespace proxima {

/// Bits of a coordinate that a Morton code takes.
inline constexpr int morton_bits = 21;

/// The Morton code of coordinates, each below 2^morton_bits.
[[nodiscard]] constexpr std::uint64_t morton_code(const std::array<std::uint32_t, 3>& at) noexcept
{
    std::uint64_t code = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::uint64_t bits = at[axis] & 0x1FFFFFU;
        bits = (bits | bits << 32U) & 0x001F00000000FFFFU;
        bits = (bits | bits << 16U) & 0x001F0000FF0000FFU;
        bits = (bits | bits << 8U) & 0x100F00F00F00F00FU;
        bits = (bits | bits << 4U) & 0x10C30C30C30C30C3U;
        bits = (bits | bits << 2U) & 0x1249249249249249U;
        code |= bits << axis;
    }
    return code;
}

/// The coordinates of a Morton code.
[[nodiscard]] constexpr std::array<std::uint32_t, 3> morton_coordinates(std::uint64_t code) noexcept
{
    std::array<std::uint32_t, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::uint64_t bits = code >> axis & 0x1249249249249249U;
        bits = (bits | bits >> 2U) & 0x10C30C30C30C30C3U;
        bits = (bits | bits >> 4U) & 0x100F00F00F00F00FU;
        bits = (bits | bits >> 8U) & 0x001F0000FF0000FFU;
        bits = (bits | bits >> 16U) & 0x001F00000000FFFFU;
        bits = (bits | bits >> 32U) & 0x00000000001FFFFFU;
        at[axis] = static_cast<std::uint32_t>(bits);
    }
    return at;
}

} // namespace proxima
