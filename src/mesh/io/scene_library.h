// The library that reads scenes for libproxima.so, the program `proxima` and others, which is opened when a 3DS, glTF or
// GLB file is first read: who reads none never loads assimp.
#pragma once

#include "mesh/io/mesh_assembler.h"

#include <filesystem>

namespace proxima::detail {

/// What the library exports: read_with_assimp, its result written to `mesh`.
using ReadScene = void(const MeshSource& source, const std::filesystem::path& folder,
                       MeshFormat format, const ReadOptions& options, Vertices vertices,
                       Result<TriangleMesh>& mesh);

inline constexpr const char* read_scene_name = "proxima_read_scene";

} // namespace proxima::detail
