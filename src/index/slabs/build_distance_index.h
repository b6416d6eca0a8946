// Builds what distances between meshes are found with from a mesh index.
//
//     auto index = build_distance_index(build_mesh_index(mesh).value());
//     auto near = mesh_distance(*index, *other, pose_of_other);
#pragma once

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/result.h"
#include "index/slabs/distance_index.h"

namespace proxima {

struct DistanceIndexOptions {
    MemoryBudget budget = {}; ///< slabs
    Threads threads = {};
    Progress* progress = nullptr; ///< watched and obeyed where given
};

/// The mesh index is shared, not copied. The same bits for any number of threads. Errors:
/// budget_exceeded, cancelled. About 0.3 us and 3 bytes per triangle.
[[nodiscard]] Result<DistanceIndex> build_distance_index(const MeshIndex& triangles,
                                                         const DistanceIndexOptions& options = {});

} // namespace proxima
