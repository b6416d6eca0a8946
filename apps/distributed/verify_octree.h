// Compares the ranks' parts with the octree that one process builds of the whole mesh.
#pragma once

#include "distributed/octree_command.h"
#include "distributed/octree_part.h"

namespace proxima {

/// Error broken_invariant on all ranks where any leaf or list differs. Rank 0 loads the whole mesh.
/// Collective.
[[nodiscard]] Status verify_octree(const OctreeRunOptions& options, const OctreePart& part,
                                   World& world);

} // namespace proxima
