// Equality of octrees as trees, whatever the order of their records.
#pragma once

#include "proxima/octree.h"

namespace proxima {

/// Whether both have the same cells, and every leaf the same triangles and class. Builders may lay
/// out the same tree in different orders. O(cells + references), thread safe.
[[nodiscard]] bool same_cells(const Octree& a, const Octree& b);

} // namespace proxima
