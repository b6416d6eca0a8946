// All pairs of triangles of two meshes that meet, watched by whoever may end the search.
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"

#include <vector>

namespace proxima {

/// Like intersecting_pairs, but reports no stage. Where the progress asks to stop, it returns soon, with some of
/// the pairs. The progress may be null.
[[nodiscard]] std::vector<TrianglePair> find_pairs(const MeshIndex& a, const MeshIndex& b,
                                                   const RigidTransform& pose_b,
                                                   const Progress* progress);

} // namespace proxima
