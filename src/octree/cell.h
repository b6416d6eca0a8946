// Addresses of octree cells, and where they lie in space.
//
//     octant bit 0 = x, bit 1 = y, bit 2 = z; a set bit is the upper half
//     key = 1 followed by one octant (3 bits) per level: root 1, its children 8..15, ...
#pragma once

#include "geometry/shapes.h"

#include <array>
#include <bit>
#include <compare>
#include <cstdint>

namespace proxima {

/// The deepest level a cell may have; the root is depth 0.
inline constexpr int max_octree_depth = 19;

/// A cell's address in any octree: Morton code with a leading one. Ordered by depth, then Morton.
struct CellKey {
    std::uint64_t bits = 1;

    friend constexpr bool operator==(CellKey, CellKey) = default;
    friend constexpr std::strong_ordering operator<=>(CellKey one, CellKey other) noexcept
    {
        return one.bits <=> other.bits;
    }
};

[[nodiscard]] constexpr int depth(CellKey key) noexcept
{
    return (static_cast<int>(std::bit_width(key.bits)) - 1) / 3;
}

/// \pre octant in [0, 8), depth(key) < max_octree_depth
[[nodiscard]] constexpr CellKey child(CellKey key, int octant) noexcept
{
    return {key.bits << 3U | static_cast<std::uint64_t>(octant)};
}

/// \pre depth(key) > 0
[[nodiscard]] constexpr CellKey parent(CellKey key) noexcept
{
    return {key.bits >> 3U};
}

/// Which child of its parent the cell is. \pre depth(key) > 0
[[nodiscard]] constexpr int octant(CellKey key) noexcept
{
    return static_cast<int>(key.bits & 7U);
}

/// Integer coordinates at the cell's depth, each in [0, 2^depth).
[[nodiscard]] std::array<std::uint32_t, 3> cell_coordinates(CellKey key) noexcept;

/// The cell with these coordinates. \pre each in [0, 2^depth), depth in [0, max_octree_depth]
[[nodiscard]] CellKey cell_key(const std::array<std::uint32_t, 3>& coordinates, int depth) noexcept;

/// The root cell in space: a cube, or a box whose cells are boxes of its proportions.
struct OctreeFrame {
    Vec3 lower = Vec3::Zero();
    Vec3 edge = Vec3::Ones(); ///< positive, finite

    /// Coordinate of the plane `index` of the 2^depth + 1 planes on `axis`: a double, the same one
    /// for every cell and depth that it bounds. Cells are closed boxes between such planes, and
    /// every overlap is decided for exactly these boxes.
    [[nodiscard]] double plane(int axis, std::uint32_t index, int depth) const noexcept
    {
        const double part = static_cast<double>(index) / static_cast<double>(1U << depth);
        return lower[axis] + part * edge[axis];
    }
};

/// The closed box of a cell, bounded by OctreeFrame::plane.
[[nodiscard]] Box cell_box(const OctreeFrame& frame, CellKey key) noexcept;

} // namespace proxima
