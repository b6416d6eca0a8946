// Reads STL meshes, ASCII and binary.
#pragma once

#include "mesh/io/mesh_assembler.h"

namespace proxima::detail {

/// A file whose length fits its binary triangle count is binary, also where it starts with "solid";
/// else one that starts with "solid" is text. Three new vertices per triangle before welding;
/// normals are passed over.
[[nodiscard]] Result<TriangleMesh> read_stl(const MeshSource& source, const ReadOptions& options,
                                            Vertices vertices);

} // namespace proxima::detail
