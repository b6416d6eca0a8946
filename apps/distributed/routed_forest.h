// The upper levels of an octree as a forest of p4est: who owns which cells.
//
//     depth 0            split where more triangles than the threshold touch, down to the routing
//       ...              depth; its leaves, weighted by their triangles, are shared by the ranks in
//     routing depth      Morton order
#pragma once

#include "distributed/world.h"
#include "proxima/octree.h"

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

class RoutedForest {
public:
    RoutedForest();
    ~RoutedForest();
    RoutedForest(const RoutedForest&) = delete;
    RoutedForest& operator=(const RoutedForest&) = delete;

    /// Splits and shares the forest. counts[depth] has the cells of that depth which triangles of
    /// this rank's slice touch; the last one is of the routing depth. Collective.
    [[nodiscard]] Status build(const std::vector<std::vector<CellCount>>& counts,
                               std::uint32_t threshold, World& world);

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
