// The fast builder: snapped grid, coarse bins, subtrees in vector lanes, joined in a fixed order.
#pragma once

#include "octree/grow_subtree.h"
#include "proxima/octree.h"

namespace proxima {

/// Nodes and references of the octree of a checked mesh whose vertices lie in the frame.
/// The same bits for any number of threads.
[[nodiscard]] Result<OctreeOutput> build_fast(const TriangleMesh& mesh, const OctreeFrame& frame,
                                              const OctreeOptions& options, GrowLimits& limits);

} // namespace proxima
