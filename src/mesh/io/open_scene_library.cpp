// read_with_assimp of libproxima.so, libproxima_c.so, the Python module and the program `proxima`: by a library beside
// them, or where it is installed.
#include "base/shared_library.h"
#include "base/text.h"
#include "mesh/io/read_with_assimp.h"
#include "mesh/io/scene_library.h"

#include <dlfcn.h>
#include <link.h>

namespace proxima::detail {

namespace {

/// The folder of the library or program that this code is part of.
std::filesystem::path own_folder()
{
    Dl_info info{};
    void* loaded = nullptr;
    if (dladdr1(reinterpret_cast<const void*>(&own_folder), &info, &loaded, RTLD_DL_LINKMAP) == 0)
        return {};
    // The loader has no name for the program, and `info` only what it was called by.
    const std::string name = static_cast<const link_map*>(loaded)->l_name;
    std::error_code unknown;
    return (name.empty() ? std::filesystem::read_symlink("/proc/self/exe", unknown)
                         : std::filesystem::path(name))
        .parent_path();
}

LibraryWanted scene_library()
{
    const std::filesystem::path folder = own_folder();
    return {.what = "the library that reads 3DS, glTF and GLB",
            .names = {folder / "proxima" / PROXIMA_SCENE_LIBRARY, folder / PROXIMA_SCENE_LIBRARY,
                      folder / PROXIMA_LIBRARY_FOLDER / "proxima" / PROXIMA_SCENE_LIBRARY},
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
