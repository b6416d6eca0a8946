// Making a mesh out of another: vertices welded, triangles picked out.
//
//     auto welded = weld_vertices(mesh);
//     const TriangleMesh patch = sub_mesh(mesh, triangles);
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <span>

namespace proxima {

/// The mesh with one vertex per position: vertices whose coordinates are equal are merged (0.0 ==
/// -0.0; NaNs of the same bits are equal too). The first vertex of a position stays, in its place
/// among the others. Triangles keep their order and number, degenerate ones too. Expected
/// O(vertices + triangles). Error: cancelled.
[[nodiscard]] Result<TriangleMesh> weld_vertices(const TriangleMesh& mesh,
                                                 const Execution& execution = {});

/// These triangles in this order, with the vertices that they use, which keep their order.
/// O(n log n) in the number of triangles named, whatever the mesh's. \pre the ids are the mesh's
[[nodiscard]] TriangleMesh sub_mesh(const TriangleMesh& mesh,
                                    std::span<const TriangleId> triangles);

} // namespace proxima
