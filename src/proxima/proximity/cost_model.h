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

/// Lists up to this length are not split: they cost one pass over the lanes.
inline constexpr std::size_t list_triangles = 16;

struct CostModel {
    double price = 0; ///< nanoseconds per byte

    static constexpr double block = 60;       ///< ns, the first block of a leaf
    static constexpr double more_blocks = 60; ///< ns, each further one
    static constexpr double step = 12;        ///< ns per level
    static constexpr double split_bytes = 64;
    static constexpr double leaf_block_bytes = 14; ///< a leaf's part of the block it shares
    static constexpr double run_entry_bytes = 24;

    [[nodiscard]] static double blocks(std::size_t triangles) noexcept
    {
        return static_cast<double>((triangles + list_triangles - 1) / list_triangles);
    }

    /// Bytes of a leaf's blocks. Proportions were measured: blocks are shared so well that it is
    /// leaves of several that take most. The builder measures the rest on a part of the mesh.
    [[nodiscard]] static double leaf_bytes(std::size_t triangles) noexcept
    {
        const double count = blocks(triangles);
        const double run = count > 1 ? run_entry_bytes * (count + 1) : 0;
        return leaf_block_bytes * count + run;
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
        return triangles > list_triangles &&
               split(probability) + 8 * price * leaf_bytes(1) + probability * block <
                   leaf(probability, triangles);
    }
};

} // namespace proxima
