// A part of a mesh as a mesh of its own.
#pragma once

#include "mesh/triangle_mesh.h"

#include <span>

namespace proxima {

/// These triangles in this order, with the vertices that they use, which keep their order.
/// O(n log n) in the number of triangles named, whatever the mesh's. \pre the ids are the mesh's
[[nodiscard]] TriangleMesh sub_mesh(const TriangleMesh& mesh,
                                    std::span<const TriangleId> triangles);

} // namespace proxima
