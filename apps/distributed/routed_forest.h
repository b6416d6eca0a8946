// The upper levels of an octree as a forest of p4est: who owns which cells.
//
//     depth 0            split where more triangles than the threshold touch, down to the routing
//       ...              depth; its leaves, weighted by their triangles, are shared by the ranks in
//     routing depth      Morton order
#pragma once

#include "distributed/world.h"
#include "proxima/octree.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace proxima {

/// A cell by its Morton index within its level, and how many triangles of a slice touch it.
struct CellCount {
    std::uint64_t cell = 0;
    std::uint64_t triangles = 0;
};

/// How many triangles touch the cells of the depths 0 to the deepest, cells in Morton order.
class CellCounts {
public:
    static constexpr std::size_t most_depths = 19;
    /// By depth: triangles that touch the cells of that depth and below it, and none before them.
    using NewFrom = std::array<std::uint64_t, most_depths>;

    explicit CellCounts(int deepest) : counts_(static_cast<std::size_t>(deepest) + 1) {}

    /// Adds a cell of the deepest level that follows those before. Throws std::bad_alloc.
    void add(std::uint64_t cell, const NewFrom& new_from);

    [[nodiscard]] int deepest() const noexcept { return static_cast<int>(counts_.size()) - 1; }
    [[nodiscard]] const std::vector<CellCount>& at(int depth) const
    {
        return counts_[static_cast<std::size_t>(depth)];
    }

private:
    std::vector<std::vector<CellCount>> counts_;
};

class RoutedForest {
public:
    RoutedForest();
    ~RoutedForest();
    RoutedForest(const RoutedForest&) = delete;
    RoutedForest& operator=(const RoutedForest&) = delete;

    /// Splits and shares the forest, by what the triangles of this rank's slice touch down to the
    /// routing depth. Collective.
    [[nodiscard]] Status build(const CellCounts& counts, std::uint32_t threshold, World& world);

    /// The rank that owns the cell's first corner. Not collective.
    [[nodiscard]] int owner(std::uint64_t cell, int depth) const;
    [[nodiscard]] int owner(CellKey key) const;

    /// This rank's leaves, in Morton order.
    [[nodiscard]] std::vector<CellKey> cells() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

} // namespace proxima
