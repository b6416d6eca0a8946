// Finds the run of rows below every block of a ray index.
#pragma once

#include "proxima/query/ray_index.h"

#include <span>
#include <vector>

namespace proxima {

/// One for every block. O(blocks). \pre parents come before their children
[[nodiscard]] std::vector<RayBlockRows> rows_of_blocks(std::span<const RayBlock> blocks,
                                                       std::uint32_t root);

} // namespace proxima
