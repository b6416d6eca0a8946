// Where the octree ends: the cheapest cut of the grown cells at a price per byte, and the price at
// which it fits the memory.
#pragma once

#include "proxima/proximity/grow_cells.h"

#include <span>

namespace proxima {

/// Bytes of nodes and blocks of the cheapest trees at the price, as the cost model has them.
[[nodiscard]] double bytes_at(std::span<const GrownTree> trees, double price);

/// The least price of [low, high] at which they take at most `bytes`; high where none does. Right
/// to 2 %. A pass over the cells for every halving of the ratio's logarithm.
[[nodiscard]] double price_for(std::span<const GrownTree> trees, double bytes, double low,
                               double high);

/// The same for a whole forest.
[[nodiscard]] double price_for(const GrownForest& forest, double bytes, double low, double high);

/// Takes away the cells below the cheapest leaves at the price, by clearing `children`, and tells
/// which leaves are better off without a list.
void cut_trees(std::span<GrownTree> trees, double price);

/// The same for a whole forest: takes away the cells below the cheapest leaves.
void cut_cells(GrownForest& forest, double price);

} // namespace proxima
