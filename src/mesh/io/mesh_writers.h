// Writers of mesh files, one per format; write_mesh chooses.
#pragma once

#include "proxima/mesh_io.h"

#include <filesystem>

namespace proxima::detail {

/// "v" and "f" statements.
[[nodiscard]] Status write_obj(const TriangleMesh& mesh, const std::filesystem::path& path,
                               const WriteOptions& options);

/// Numbers alone.
[[nodiscard]] Status write_off(const TriangleMesh& mesh, const std::filesystem::path& path,
                               const WriteOptions& options);

/// Elements "vertex" of doubles and "face".
[[nodiscard]] Status write_ply(const TriangleMesh& mesh, const std::filesystem::path& path,
                               const WriteOptions& options);

/// One solid with computed normals; the normal of a triangle without area is zero.
[[nodiscard]] Status write_stl(const TriangleMesh& mesh, const std::filesystem::path& path,
                               const WriteOptions& options);

} // namespace proxima::detail
