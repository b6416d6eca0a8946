#include "proxima/mesh_io.h"

#include "base/file_extension.h"

#include <array>

namespace proxima {

namespace {

struct FormatNames {
    MeshFormat format;
    std::string_view name;
    std::string_view extension;
};

constexpr std::array<FormatNames, 8> format_names{{
    {MeshFormat::obj, "OBJ", ".obj"},
    {MeshFormat::ply, "PLY", ".ply"},
    {MeshFormat::stl, "STL", ".stl"},
    {MeshFormat::off, "OFF", ".off"},
    {MeshFormat::xyz, "XYZ", ".xyz"},
    {MeshFormat::three_ds, "3DS", ".3ds"},
    {MeshFormat::gltf, "glTF", ".gltf"},
    {MeshFormat::glb, "GLB", ".glb"},
}};

} // namespace

std::string_view format_name(MeshFormat format) noexcept
{
    return format_names[static_cast<std::size_t>(format)].name;
}

std::optional<MeshFormat> format_of_path(const std::filesystem::path& path)
{
    const std::string extension = lower_case_extension(path);
    for (const FormatNames& names : format_names) {
        if (names.extension == extension) return names.format;
    }
    return std::nullopt;
}

std::string known_mesh_extensions()
{
    std::string list;
    for (const FormatNames& names : format_names) {
        if (!list.empty()) list += ", ";
        list += names.extension;
    }
    return list;
}

} // namespace proxima
