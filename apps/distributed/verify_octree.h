// Compares the ranks' parts with the octree that one process builds of the whole mesh.
#pragma once

#include "distributed/octree_command.h"
#include "distributed/route_triangles.h"

namespace proxima {

/// Error broken_invariant on all ranks where any leaf or list differs. Rank 0 loads the whole mesh.
/// Collective.
[[nodiscard]] Status verify_octree(const OctreeRunOptions& options, const RoutedPart& part,
                                   const GrownCells& grown, World& world);

} // namespace proxima
