// read_with_assimp of libproxima.so and the Python module: by a library beside them.
#include "base/shared_library.h"
#include "base/text.h"
#include "mesh/io/read_with_assimp.h"
#include "mesh/io/scene_library.h"

#include <dlfcn.h>

namespace proxima::detail {

namespace {

/// The folder of the library or program that this code is part of.
std::filesystem::path own_folder()
{
    Dl_info info{};
    if (dladdr(reinterpret_cast<const void*>(&own_folder), &info) == 0) return {};
    return std::filesystem::path(info.dli_fname).parent_path();
}

LibraryWanted scene_library()
{
    const std::filesystem::path folder = own_folder();
    return {.what = "the library that reads 3DS, glTF and GLB",
            .names = {folder / "proxima" / PROXIMA_SCENE_LIBRARY, folder / PROXIMA_SCENE_LIBRARY},
            .named = {},
            .advice = "install it there, or convert the file to OBJ, PLY, STL or OFF"};
}

} // namespace

Result<TriangleMesh> read_with_assimp(const MeshSource& source, const std::filesystem::path& folder,
                                      MeshFormat format, const ReadOptions& options,
                                      Vertices vertices)
{
    static const auto library = open_function<ReadScene>(scene_library(), read_scene_name);
    if (!library) {
        return fail(ErrorCode::unsupported_format, library.error().message, source.name);
    }
    Result<TriangleMesh> mesh;
    library->call(source, folder, format, options, vertices, mesh);
    return mesh;
}

} // namespace proxima::detail
