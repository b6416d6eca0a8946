// How long single queries take, measured on this machine.
#pragma once

#include "proxima/mesh/triangle_mesh.h"
#include "proxima/proximity/proximity_octree.h"

namespace proxima {

/// Nanoseconds per query.
struct QueryTiming {
    int queries = 0;
    double median = 0;
    double max = 0;
};

/// Times queries one by one on the calling thread: half of them anywhere in the box 1.2 times the
/// mesh's, half within 1 % of its diagonal of the surface, always the same ones. Each is asked five
/// times and the least time kept, less what reading the clock takes. About 50 ms.
/// \pre the octree is the mesh's
[[nodiscard]] QueryTiming time_queries(const ProximityOctree& octree, const TriangleMesh& mesh);

} // namespace proxima
