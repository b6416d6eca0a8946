// What cells cost: nanoseconds of a query that ends there, and bytes of the structure.
//
// A query is taken to fall half of the time anywhere in the box 1.2 times the mesh's, half of the
// time near the surface. A cell that it falls into with probability P costs
//
//     P worth(listed(n)) + price * leaf_bytes(n)     as a leaf with a list of n triangles
//     P worth(searched(n))                           as one without, that searches the tree
//     P step + price * split_bytes + its children    split
//
// `price` is what a byte is worth in nanoseconds: the builder finds the one at which the cheapest
// tree just fits the memory. Slow queries count for more than their time, t (1 + t/s + (t/s)^2):
// who asks a thousand times a second waits for the slowest. Times were measured; only their ratios
// matter.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace proxima {

/// Lists up to this length are not split: they cost one pass over the lanes.
inline constexpr std::size_t list_triangles = 16;

struct CostModel {
    double price = 0; ///< nanoseconds per byte

    static constexpr double block = 135;      ///< ns of a query with one block
    static constexpr double more_blocks = 62; ///< ns, each further one
    static constexpr double many_blocks = 25; ///< from where on bounds pass over most of them
    static constexpr double search = 3000;    ///< ns, of the tree over all triangles
    static constexpr double search_more = 16; ///< ns per triangle that the list would have
    static constexpr double slow = 2000;      ///< ns
    static constexpr double step = 12;        ///< ns per level
    static constexpr double split_bytes = 64;
    static constexpr double leaf_block_bytes = 14; ///< a leaf's part of the block it shares
    static constexpr double run_entry_bytes = 24;

    [[nodiscard]] static double blocks(std::size_t triangles) noexcept
    {
        const std::size_t whole = (triangles + list_triangles - 1) / list_triangles;
        return static_cast<double>(whole);
    }

    /// Bytes of a leaf's list. The builder measures on a part of the mesh how far this is off.
    [[nodiscard]] static double leaf_bytes(std::size_t triangles) noexcept
    {
        if (triangles <= list_triangles) return leaf_block_bytes;
        return run_entry_bytes * (1.25 * blocks(triangles) + 1);
    }

    [[nodiscard]] static double worth(double nanoseconds) noexcept
    {
        const double parts = nanoseconds / slow;
        return nanoseconds * (1 + parts + parts * parts);
    }

    /// Of a query in a leaf with a list.
    [[nodiscard]] static double listed_time(std::size_t triangles) noexcept
    {
        const double more = blocks(triangles) - 1;
        if (more <= many_blocks) return block + more_blocks * more;
        // To the power 5/8, by roots that are rounded the same way everywhere.
        const double root = std::sqrt(more / many_blocks);
        return block + more_blocks * many_blocks * root * std::sqrt(std::sqrt(root));
    }

    /// With a list.
    [[nodiscard]] double listed(double probability, std::size_t triangles) const noexcept
    {
        return probability * worth(listed_time(triangles)) + price * leaf_bytes(triangles);
    }

    /// Without one.
    [[nodiscard]] static double searched(double probability, std::size_t triangles) noexcept
    {
        return probability * worth(search + search_more * static_cast<double>(triangles));
    }

    /// The cheaper of the two.
    [[nodiscard]] double leaf(double probability, std::size_t triangles) const noexcept
    {
        return std::min(listed(probability, triangles), searched(probability, triangles));
    }

    [[nodiscard]] double split(double probability) const noexcept
    {
        return probability * step + price * split_bytes;
    }

    /// Whether splitting could pay where the children are as good as they can be: eight leaves of `fewest`
    /// triangles.
    [[nodiscard]] bool may_split(double probability, std::size_t triangles,
                                 std::size_t fewest) const noexcept
    {
        return triangles > list_triangles && split(probability) + 8 * price * leaf_bytes(fewest) +
                                                     probability * worth(listed_time(fewest)) <
                                                 leaf(probability, triangles);
    }
};

} // namespace proxima
