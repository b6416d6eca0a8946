// Triangles that a command found, as a file: their ids, or a mesh of just them.
//
//     .csv                a header line `triangle`, then an id per line
//     .npy                a column of float64
//     .obj .ply .off .stl the mesh, triangles in the given order
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <span>
#include <string>

namespace proxima {

/// What would go wrong with a mesh written under this name. Error unsupported_format.
[[nodiscard]] Status check_mesh_file_format(const std::string& path);

/// What would go wrong with a file of this name. Error unsupported_format.
[[nodiscard]] Status check_triangle_file_format(const std::string& path);

/// By extension. Errors: unsupported_format, file_not_writable, limit_exceeded (as write_mesh),
/// cancelled. \pre the ids are the mesh's
[[nodiscard]] Status write_triangle_file(const TriangleMesh& mesh,
                                         std::span<const TriangleId> triangles,
                                         const std::string& path, Progress* progress = nullptr);

} // namespace proxima
