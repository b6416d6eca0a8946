// View volume culling as the thesis renders it: the triangles that the visible cells list
// (thesis section 5.4).
#pragma once

#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"
#include "proxima/view_volume.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// What a walk over the cells found.
struct CellCulling {
    std::vector<TriangleId> triangles; ///< ascending, each once
    std::uint64_t cells = 0;           ///< visible leaves that hold triangles
};

/// The triangles of all leaves that the volume intersects: every triangle that has a point in common
/// with the volume, and neighbours of these in the same leaves. cull_volume.h is the fast way, and
/// tests triangles too. Thread safe, allocates the list and a bit per triangle.
/// \pre leaves list all triangles that touch them
[[nodiscard]] CellCulling cull_by_cells(const Octree& octree, const ViewVolume& volume);

} // namespace proxima
