// Reads Wavefront OBJ meshes.
#pragma once

#include "mesh/io/mesh_assembler.h"

namespace proxima::detail {

/// Vertices from "v", polygons from "f" (and its old name "fo") with any of the forms 1, 1/2, 1//3,
/// 1/2/3 and indices from the end; all objects and groups together. Known statements without
/// surface are passed over, free-form surfaces and unknown words refused.
[[nodiscard]] Result<TriangleMesh> read_obj(const MeshSource& source, const ReadOptions& options,
                                            Vertices vertices);

} // namespace proxima::detail
