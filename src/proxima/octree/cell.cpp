#include "proxima/octree/cell.h"

namespace proxima {

namespace {

/// Every third bit of `bits`, packed: the inverse of spreading.
std::uint32_t gather_third_bits(std::uint64_t bits) noexcept
{
    bits &= 0x1249249249249249U;
    bits = (bits | bits >> 2U) & 0x10C30C30C30C30C3U;
    bits = (bits | bits >> 4U) & 0x100F00F00F00F00FU;
    bits = (bits | bits >> 8U) & 0x001F0000FF0000FFU;
    bits = (bits | bits >> 16U) & 0x001F00000000FFFFU;
    bits = (bits | bits >> 32U) & 0x00000000001FFFFFU;
    return static_cast<std::uint32_t>(bits);
}

/// Bits of `value` (21 at most) moved to every third place.
std::uint64_t spread_to_third_bits(std::uint32_t value) noexcept
{
    std::uint64_t bits = value & 0x1FFFFFU;
    bits = (bits | bits << 32U) & 0x001F00000000FFFFU;
    bits = (bits | bits << 16U) & 0x001F0000FF0000FFU;
    bits = (bits | bits << 8U) & 0x100F00F00F00F00FU;
    bits = (bits | bits << 4U) & 0x10C30C30C30C30C3U;
    bits = (bits | bits << 2U) & 0x1249249249249249U;
    return bits;
}

} // namespace

std::array<std::uint32_t, 3> cell_coordinates(CellKey key) noexcept
{
    const std::uint64_t morton = key.bits ^ (std::uint64_t{1} << (3 * depth(key)));
    return {gather_third_bits(morton), gather_third_bits(morton >> 1U),
            gather_third_bits(morton >> 2U)};
}

CellKey cell_key(const std::array<std::uint32_t, 3>& coordinates, int depth) noexcept
{
    const std::uint64_t morton = spread_to_third_bits(coordinates[0]) |
                                 spread_to_third_bits(coordinates[1]) << 1U |
                                 spread_to_third_bits(coordinates[2]) << 2U;
    return {std::uint64_t{1} << (3 * depth) | morton};
}

Box cell_box(const OctreeFrame& frame, CellKey key) noexcept
{
    const auto coordinates = cell_coordinates(key);
    const int level = depth(key);
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
        const std::uint32_t index = coordinates[static_cast<std::size_t>(axis)];
        box.lower[axis] = frame.plane(axis, index, level);
        box.upper[axis] = frame.plane(axis, index + 1, level);
    }
    return box;
}

} // namespace proxima
