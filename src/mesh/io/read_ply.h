// Reads PLY meshes: ASCII and both binaries, faces and triangle strips.
#pragma once

#include "mesh/io/mesh_assembler.h"

namespace proxima::detail {

/// Vertices from the element "vertex" (x, y, z of any number type), triangles from "face" and
/// "tristrips" (lists "vertex_indices" or "vertex_index" of any types; -1 parts strips). Everything
/// else is passed over. In ASCII each element is a line.
[[nodiscard]] Result<TriangleMesh> read_ply(const MeshSource& source, const ReadOptions& options,
                                            Vertices vertices);

} // namespace proxima::detail
