// Whether the faces of a 3DS file name vertices that are there: assimp takes the last one for others.
#pragma once

#include "mesh/io/mesh_source.h"
#include "proxima/result.h"

namespace proxima::detail {

/// Refuses faces of an object that name vertices beyond its own. What is no 3DS file, or is cut off, is
/// left to assimp. Errors: malformed_file. O(bytes).
[[nodiscard]] Status check_3ds_faces(const MeshSource& source);

} // namespace proxima::detail
