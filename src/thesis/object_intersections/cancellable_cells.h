// The thesis's intersection of two meshes by their octrees, watched by whoever may end it.
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/thesis.h"

namespace proxima {

/// Like intersect_by_cells, but reports no stage. Where the progress asks to stop, it returns soon, with some of
/// the pairs. The progress may be null.
[[nodiscard]] CellIntersection intersect_by_cells(const MeshCells& a, const MeshCells& b,
                                                  const RigidTransform& pose_b,
                                                  const Progress* progress);

} // namespace proxima
