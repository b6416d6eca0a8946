#include "proxima/octree.h"

#include "base/morton_code.h"

namespace proxima {

std::array<std::uint32_t, 3> cell_coordinates(CellKey key) noexcept
{
    const std::uint64_t morton = key.bits ^ (std::uint64_t{1} << (3 * depth(key)));
    return morton_coordinates(morton);
}

CellKey cell_key(const std::array<std::uint32_t, 3>& coordinates, int depth) noexcept
{
    return {std::uint64_t{1} << (3 * depth) | morton_code(coordinates)};
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
