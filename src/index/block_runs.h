// Writes into the nodes of a mesh index which rows lie below their children.
#pragma once

#include "index/mesh_index.h"

#include <span>

namespace proxima {

/// Sets first_row, order and starts of every node. O(blocks). \pre block 0 is the empty leaf
void write_runs(std::span<IndexBlock> blocks, std::uint32_t root);

} // namespace proxima
