// The mesh file formats and the file names that stand for them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace proxima {

enum class MeshFormat : std::uint8_t { obj, ply, stl, off, three_ds, gltf, glb };

/// Short name for messages: "OBJ", "3DS".
[[nodiscard]] std::string_view format_name(MeshFormat format) noexcept;

/// The format that the extension of `path` stands for, in any letter case.
[[nodiscard]] std::optional<MeshFormat> format_of_path(const std::filesystem::path& path);

/// ".obj, .ply, .stl, ...": the extensions that format_of_path knows.
[[nodiscard]] std::string known_mesh_extensions();

} // namespace proxima
