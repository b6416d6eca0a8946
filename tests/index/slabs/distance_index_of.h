// The index of a small mesh for distances, with blocks to go through.
#pragma once

#include "index/build_mesh_index.h"
#include "index/slabs/build_distance_index.h"
#include "proxima/octree.h"

namespace proxima::testing {

inline DistanceIndex index_of(const TriangleMesh& mesh)
{
    const auto octree =
        build_octree(mesh, {.max_depth = 3, .classification = Classification::none}).value();
    return build_distance_index(build_mesh_index(octree, mesh).value()).value();
}

} // namespace proxima::testing
