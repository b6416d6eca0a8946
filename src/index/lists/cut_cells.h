// Where the octree ends: the cheapest cut of the grown cells at a price per byte.
#pragma once

#include "index/lists/grow_cells.h"

#include <span>

namespace proxima {

/// Marks the cells that end in the cheapest trees at the price, and which leaves are better off
/// without a list. For a price not below the one that they were grown at the best there is; may be
/// done again at any other.
void cut_trees(std::span<GrownTree> trees, double price);

/// The same for a whole forest.
void cut_cells(GrownForest& forest, double price);

} // namespace proxima
