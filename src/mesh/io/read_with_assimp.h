// Reads 3DS, glTF and GLB through assimp; part of the library only where it was built with it.
#pragma once

#include "mesh/io/mesh_assembler.h"

#include <filesystem>

namespace proxima::detail {

/// Reads source.text and the files in or below `folder` that a glTF refers to; none where it is
/// empty. All meshes of the scene, placed by its nodes in double, polygons of fewer than three
/// corners left out.
[[nodiscard]] Result<TriangleMesh> read_with_assimp(const MeshSource& source,
                                                    const std::filesystem::path& folder,
                                                    MeshFormat format, const ReadOptions& options,
                                                    Vertices vertices);

} // namespace proxima::detail
