// Reads XYZ files: point clouds as text.
#pragma once

#include "mesh/io/mesh_assembler.h"

namespace proxima::detail {

/// A point on each line, as three numbers with blanks between them; further numbers (a normal, a
/// colour, an intensity) are passed over, and so are empty lines and comments from '#' on.
[[nodiscard]] Result<TriangleMesh> read_xyz(const MeshSource& source, const ReadOptions& options,
                                            Vertices vertices);

} // namespace proxima::detail
