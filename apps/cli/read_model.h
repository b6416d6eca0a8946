// The mesh of a MODEL, for commands and the viewer.
#pragma once

#include "proxima/execution.h"
#include "proxima/mesh_io.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <string>
#include <string_view>

namespace proxima {

/// The mesh of a built-in name, of a file of a mesh, or of an index. Errors as sample_mesh(), read_mesh() and
/// load_index(); where there is no such file, with the built-in that has a name like it.
[[nodiscard]] Result<TriangleMesh> read_model(const std::string& model, Primitives primitives,
                                              const Execution& execution);

/// Whether the file has no triangles but perhaps points or lines, which only --points-and-lines reads.
[[nodiscard]] bool may_be_of_points(const std::string& model, Primitives primitives,
                                    const TriangleMesh& mesh);
inline constexpr std::string_view points_hint = "; --points-and-lines reads points and lines";

} // namespace proxima
