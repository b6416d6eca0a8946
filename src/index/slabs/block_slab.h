// Slabs about the blocks of a mesh index: distances between meshes are found sooner with them.
//
//     \  upper  \          lower <= n . (p - c) <= upper for all points p of the block's triangles,
//      \ .-'--.  \         c the center of its box, n across its patch of surface: slabs save what
//       \'  lower \        boxes askew to the surface waste
//
// Slabs are in the order of the blocks, so that those of a node's children lie side by side.
#pragma once

#include <array>
#include <cstdint>

namespace proxima {

/// A slab in eight bytes. With e the reach of the box along n, the sum of |n_k| half_k:
struct BlockSlab {
    std::uint32_t normal = 0; ///< x, y, z from the top in ten bits each, signed, times 2^-9
    std::uint32_t extent = 0; ///< upper, lower from the top in sixteen bits each, signed, times
                              ///< e 2^-15
};

/// A slab as numbers; `lower` and `upper` in units of e.
struct SlabNumbers {
    std::array<float, 3> normal;
    float lower;
    float upper;
};

inline SlabNumbers read_slab(const BlockSlab& slab) noexcept
{
    const auto number = [&](unsigned bits_above) {
        return static_cast<float>(static_cast<std::int32_t>(slab.normal << bits_above) >> 22) *
               0x1p-9F;
    };
    return {{number(0), number(10), number(20)},
            static_cast<float>(static_cast<std::int32_t>(slab.extent << 16U) >> 16) * 0x1p-15F,
            static_cast<float>(static_cast<std::int32_t>(slab.extent) >> 16) * 0x1p-15F};
}

} // namespace proxima
