// Classes of the empty leaves of an octree that is spread over ranks: those that build_octree finds.
//
//     rank 0 | rank 1     1. Each rank finds the components and regions of its own empty cells, and
//      . . . | . . .         ties their winding numbers by rays that stay in its cells.
//      . +---|--+  .      2. What is not tied to the outside is counted along a line through all
//      . | a = b|  .         ranks, each of which adds whole numbers.
//      . +---|--+  .      3. Cells at borders meet their neighbours on other ranks, and rank 0 counts
//                            components.
//
// Near holes, cells that a cap may touch are decided by the mesh's winding number there, a sum of
// solid angles with a bound on its error. Where that cannot decide, the work ends with an error.
#pragma once

#include "distributed/route_triangles.h"
#include "octree/grow_part.h"

namespace proxima {

/// Sets the classes of the empty cells below part.cells in grown.arrays.nodes and grown.cells, and
/// returns what build_octree says of the whole octree's. `caps` are those of whole_caps. Collective.
[[nodiscard]] Result<ClassificationSummary>
classify_part(const RoutedPart& part, const OctreeFrame& frame, const OctreeParameters& parameters,
              const TriangleMesh& caps, GrownPart& grown, World& world);

} // namespace proxima
