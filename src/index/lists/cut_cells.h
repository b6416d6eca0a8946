// Where the octree ends: the cheapest cut of the grown cells at a price per byte.
#pragma once

#include "index/lists/grow_cells.h"
#include "proxima/execution.h"

#include <span>

namespace proxima {

/// Marks the cells that end in the cheapest trees at the price, and which leaves are better off
/// without a list. For a price not below the one that they were grown at the best there is; may be
/// done again at any other. Returns the bytes that this takes by the cost model, which falls as the
/// price rises.
double cut_trees(std::span<GrownTree> trees, double price, Threads threads);

/// The same for a whole forest.
double cut_cells(GrownForest& forest, double price, Threads threads);

} // namespace proxima
