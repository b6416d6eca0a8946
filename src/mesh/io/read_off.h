// Reads OFF meshes, the format of Geomview.
#pragma once

#include "mesh/io/mesh_assembler.h"

namespace proxima::detail {

/// Text OFF with its variants of three dimensions: OFF, NOFF (normals), COFF (colours), STOFF
/// (texture) and their combinations; colours of faces; comments; counts on the first line or the
/// next. Homogeneous (4OFF), n-dimensional (nOFF) and binary files are refused.
[[nodiscard]] Result<TriangleMesh> read_off(const MeshSource& source, const ReadOptions& options,
                                            Vertices vertices);

} // namespace proxima::detail
