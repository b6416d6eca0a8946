// The index of a small mesh for distances, with blocks to go through.
#pragma once

#include "index/build_mesh_index.h"
#include "index/slabs/build_distance_index.h"

namespace proxima::testing {

inline DistanceIndex index_of(const TriangleMesh& mesh)
{
    return build_distance_index(build_mesh_index(mesh).value()).value();
}

} // namespace proxima::testing
