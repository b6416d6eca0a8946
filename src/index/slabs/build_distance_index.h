// Builds what distances between meshes are found with from a mesh index.
//
//     auto index = build_distance_index(build_mesh_index(mesh).value());
//     auto near = mesh_distance(*index, *other, pose_of_other);
#pragma once

#include "index/slabs/distance_index.h"
#include "proxima/execution.h"
#include "proxima/result.h"

namespace proxima {

struct DistanceIndexOptions {
    Execution execution = {}; ///< budget: slabs
};

/// The mesh index is shared, not copied. The same bits for any number of threads. Errors:
/// budget_exceeded, cancelled. About 0.3 us and 3 bytes per triangle.
[[nodiscard]] Result<DistanceIndex> build_distance_index(const MeshIndex& triangles,
                                                         const DistanceIndexOptions& options = {});

} // namespace proxima
