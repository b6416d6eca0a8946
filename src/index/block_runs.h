// Writes into the nodes of a mesh index which rows lie below their children.
#pragma once

#include "index/mesh_index.h"

#include <span>

namespace proxima {

/// Sets first_row, order and starts of one node. \pre its children are blocks, the nodes among them
/// have their first_row, and there is one but the empty leaf, block 0
void write_run(std::span<const IndexBlock> blocks, IndexNode& node);

/// Sets first_row, order and starts of every node. O(blocks). \pre block 0 is the empty leaf
void write_runs(std::span<IndexBlock> blocks, std::uint32_t root);

} // namespace proxima
