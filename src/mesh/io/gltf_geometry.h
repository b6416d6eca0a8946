// Whether a glTF's geometry is stored in a way that assimp reads right, found out from its JSON:
// assimp takes numbers of other types for floats, and passes over extensions that it does not know.
#pragma once

#include "mesh/io/json_text.h"
#include "mesh/io/mesh_source.h"

namespace proxima::detail {

/// Refuses a required extension that changes geometry and is not read, positions that are no float
/// triples, indices that are no unsigned integers, and lists of triangles that end within one.
/// Errors: malformed_file, unsupported_format. O(json).
[[nodiscard]] Status check_gltf_geometry(const MeshSource& source, const JsonText& json);

} // namespace proxima::detail
