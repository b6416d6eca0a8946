// Up to 32 triangles as a query reads them: vertices on a grid of 16 bits, shared by the triangles,
// triangles as three 5-bit indices of vertices. About 190 bytes for 15 triangles.
//
//     header    origin 3 x 4 | inverse unit 4 | slack 2 x 2 | base 4 | counts 4      28 bytes
//     vertices  x 2 n | y 2 n | z 2 n      in units from the origin
//     corners   2 per triangle: indices of its vertices, 5 bits each
//     ranks     2 per triangle (4 where wide): rank - base
//
// Distances to the rounded triangles differ from the true ones by at most sqrt(3)/2 units; how far
// float arithmetic can be off is in the slack, see `slack_of` in block.cpp. Everything within that
// of the least distance is looked at again in doubles.
#pragma once

#include "index/lists/cost_model.h"
#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// Triangles of a block at most.
inline constexpr std::size_t block_triangles = 32;

/// Vertices of a block at most.
inline constexpr std::size_t block_vertices = 32;

/// What follows a block in memory at least, so that whole lanes can be read.
inline constexpr std::size_t block_padding = 128;

/// Blocks begin at multiples of it.
inline constexpr std::size_t block_alignment = 8;

struct BlockHeader {
    float origin[3] = {};          ///< in the root's frame
    float inverse_unit = 1;        ///< units per length of the frame
    std::uint16_t slack_size = 0;  ///< upper half of a float: units
    std::uint16_t slack_reach = 0; ///< upper half of a float: units per unit of distance
    std::uint32_t base = 0;        ///< least rank
    std::uint8_t vertices = 0;
    std::uint8_t triangles = 0;
    std::uint8_t wide = 0; ///< 1 where ranks take 4 bytes
    std::uint8_t unused = 0;
};
static_assert(sizeof(BlockHeader) == 28);

/// A float of which only the upper 16 bits are kept, rounded up. \pre not negative
[[nodiscard]] std::uint16_t upper_half(float value) noexcept;

/// Where parts of a block begin, in bytes from its header.
struct BlockLayout {
    std::size_t corners = 0;
    std::size_t ranks = 0;
    std::size_t end = 0; ///< not yet aligned
};
[[nodiscard]] constexpr BlockLayout block_layout(std::size_t vertices, std::size_t triangles,
                                                 bool wide) noexcept
{
    BlockLayout layout;
    layout.corners = sizeof(BlockHeader) + 6 * vertices;
    layout.ranks = layout.corners + 2 * triangles;
    layout.end = layout.ranks + (wide ? 4 : 2) * triangles;
    return layout;
}

/// A triangle that goes into a block.
struct BlockTriangle {
    std::uint32_t rank = 0;
    std::array<std::uint32_t, 3> vertices = {}; ///< equal numbers are the same point
};

/// Appends a block, aligned, and returns where it begins. `positions` are in the root's frame.
/// \pre 1 to 32 triangles of distinct ranks and at most 32 vertices
std::size_t append_block(std::span<const BlockTriangle> triangles, std::span<const Vec3> positions,
                         std::vector<std::byte>& arena);

} // namespace proxima
