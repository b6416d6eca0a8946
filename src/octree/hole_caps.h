// Imaginary triangles that close a mesh's holes, so that it winds a whole number of times round
// every point.
//
// An edge is balanced where as many triangles run along it one way as the other. The unbalanced
// ones form closed walks: the rims of holes, of flipped patches, of sheets. A fan from each rim's
// middle to its edges makes them balanced too.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

namespace proxima {

/// The fans; no triangles where the mesh is closed and consistently oriented. Vertices at equal
/// positions are one. With w the mesh's winding number and c that of the caps, w + c is a whole
/// number everywhere off both surfaces, and 0 outside the mesh's bounding box, which contains the
/// caps. O(triangles) time and scratch. Error cancelled by `progress`, stage "looking for holes".
/// \pre checked_bounding_box(mesh)
[[nodiscard]] Result<TriangleMesh> hole_caps(const TriangleMesh& mesh, Progress* progress);

} // namespace proxima
