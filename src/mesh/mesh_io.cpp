#include "proxima/mesh_io.h"

#include "base/input_file.h"
#include "base/text.h"
#include "mesh/io/mesh_source.h"
#include "mesh/io/mesh_writers.h"
#include "mesh/io/read_obj.h"
#include "mesh/io/read_off.h"
#include "mesh/io/read_ply.h"
#include "mesh/io/read_stl.h"
#include "mesh/io/read_xyz.h"
#ifdef PROXIMA_WITH_ASSIMP
#include "mesh/io/read_with_assimp.h"
#endif

#include <new>

namespace proxima {

namespace {

detail::Vertices vertices_of(MeshFormat format, Weld weld) noexcept
{
    const bool repeats_vertices = format == MeshFormat::stl || format == MeshFormat::three_ds;
    const bool welds =
        weld == Weld::exact_positions || (weld == Weld::by_format && repeats_vertices);
    return welds ? detail::Vertices::welded : detail::Vertices::as_they_are;
}

Result<TriangleMesh> read_scene(const detail::MeshSource& source,
                                [[maybe_unused]] const std::filesystem::path& folder,
                                MeshFormat format, [[maybe_unused]] const ReadOptions& options)
{
#ifdef PROXIMA_WITH_ASSIMP
    return detail::read_with_assimp(source, folder, format, options,
                                    vertices_of(format, options.weld));
#else
    return fail(ErrorCode::unsupported_format,
                concat(format_name(format),
                       " is read by builds configured with PROXIMA_WITH_ASSIMP=ON: build one or "
                       "convert the file to OBJ, PLY, STL or OFF"),
                source.name);
#endif
}

// `folder` is where files lie that a scene refers to: empty for data in memory.
Result<TriangleMesh> read_source(const detail::MeshSource& source,
                                 const std::filesystem::path& folder, MeshFormat format,
                                 const ReadOptions& options)
{
    const detail::Vertices vertices = vertices_of(format, options.weld);
    try {
        switch (format) {
        case MeshFormat::obj:
            return detail::read_obj(source, options, vertices);
        case MeshFormat::ply:
            return detail::read_ply(source, options, vertices);
        case MeshFormat::stl:
            return detail::read_stl(source, options, vertices);
        case MeshFormat::off:
            return detail::read_off(source, options, vertices);
        case MeshFormat::xyz:
            return detail::read_xyz(source, options, vertices);
        case MeshFormat::three_ds:
        case MeshFormat::gltf:
        case MeshFormat::glb:
            break;
        }
        return read_scene(source, folder, format, options);
    } catch (const std::bad_alloc&) {
        return fail(
            ErrorCode::budget_exceeded,
            "the memory for this mesh could not be had: close other programs or decimate it",
            source.name);
    }
}

tl::unexpected<Error> unknown_extension(const std::filesystem::path& path, std::string_view known)
{
    return fail(ErrorCode::unsupported_format,
                concat("the extension \"", path.extension().string(), "\" is none of ", known,
                       ": rename or convert the file"),
                path.string());
}

} // namespace

Result<TriangleMesh> read_mesh(const std::filesystem::path& path, const ReadOptions& options)
{
    const auto format = format_of_path(path);
    std::error_code error; // such as a folder that may not be entered: reading says which
    const bool is_there = std::filesystem::exists(path, error);
    if (!is_there && !error) {
        return fail(ErrorCode::file_not_found, "there is no such file: check the path",
                    path.string());
    }
    if (!format && !std::filesystem::is_directory(path, error)) {
        return unknown_extension(path, known_mesh_extensions());
    }
    const auto bytes = read_file(path, {.budget = options.execution.budget,
                                        .progress = options.execution.progress,
                                        .advice = "raise the budget or split the mesh"});
    if (!bytes) return tl::unexpected(bytes.error());
    const std::filesystem::path folder = path.parent_path();
    return read_source({path.string(), bytes->text()}, folder.empty() ? "." : folder, *format,
                       options);
}

Result<TriangleMesh> read_mesh_from_memory(std::span<const std::byte> bytes, MeshFormat format,
                                           const ReadOptions& options)
{
    const detail::MeshSource source{concat(format_name(format), " data"),
                                    {reinterpret_cast<const char*>(bytes.data()), bytes.size()}};
    if (bytes.empty()) return fail(ErrorCode::malformed_file, "there are no bytes", source.name);
    return read_source(source, {}, format, options);
}

Status write_mesh(const TriangleMesh& mesh, const std::filesystem::path& path,
                  const WriteOptions& options)
{
    const auto format = format_of_path(path);
    if (format == MeshFormat::obj) return detail::write_obj(mesh, path, options);
    if (format == MeshFormat::ply) return detail::write_ply(mesh, path, options);
    if (format == MeshFormat::stl) return detail::write_stl(mesh, path, options);
    if (format == MeshFormat::off) return detail::write_off(mesh, path, options);
    if (!format) return unknown_extension(path, ".obj, .ply, .stl, .off");
    return fail(ErrorCode::unsupported_format,
                concat(format_name(*format), " is not written: choose .obj, .ply, .stl or .off"),
                path.string());
}

} // namespace proxima
