// What cells cost: nanoseconds of a query that ends there, and bytes of the structure.
//
// A query is taken to fall half of the time anywhere in the box 1.2 times the mesh's, half of the
// time near the surface. A cell that it falls into with probability P costs, as a leaf of n
// triangles,
//
//     P (block + more (ceil(n / 16) - 1)) + price * bytes(n)
//
// and split P step + price * 32 + its children. `price` is what a byte is worth in nanoseconds: the
// builder finds the one at which the cheapest tree just fits the memory. Times are proportions that
// were measured; only their ratios matter.
#pragma once

#include <algorithm>
#include <cstddef>

namespace proxima {

/// Triangles of a block at most.
inline constexpr std::size_t block_triangles = 16;

struct CostModel {
    double price = 0; ///< nanoseconds per byte

    static constexpr double block = 60;       ///< ns, the first block of a leaf
    static constexpr double more_blocks = 60; ///< ns, each further one
    static constexpr double step = 12;        ///< ns per level
    static constexpr double split_bytes = 32;
    static constexpr double block_bytes = 200;
    static constexpr double leaves_per_block = 4;

    [[nodiscard]] static double blocks(std::size_t triangles) noexcept
    {
        return static_cast<double>((triangles + block_triangles - 1) / block_triangles);
    }

    /// Bytes of a leaf's blocks: most leaves share theirs.
    [[nodiscard]] static double leaf_bytes(std::size_t triangles) noexcept
    {
        const double filled = static_cast<double>(triangles) / block_triangles;
        return block_bytes * (0.25 + 0.75 * filled) / leaves_per_block;
    }

    [[nodiscard]] double leaf(double probability, std::size_t triangles) const noexcept
    {
        return probability * (block + more_blocks * (blocks(triangles) - 1)) +
               price * leaf_bytes(triangles);
    }

    [[nodiscard]] double split(double probability) const noexcept
    {
        return probability * step + price * split_bytes;
    }

    /// Whether splitting could pay however good the children are: eight leaves of one triangle.
    [[nodiscard]] bool may_split(double probability, std::size_t triangles) const noexcept
    {
        return triangles > block_triangles &&
               split(probability) + 8 * price * leaf_bytes(1) + probability * block <
                   leaf(probability, triangles);
    }
};

} // namespace proxima
