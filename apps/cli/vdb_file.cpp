#include "cli/vdb_file.h"

#include "base/shared_library.h"

#include <filesystem>

namespace proxima {

namespace {

/// Beside the program, where it is built, or where it is installed.
Result<SharedLibrary> open_vdb_library()
{
    std::error_code unknown;
    const std::filesystem::path folder =
        std::filesystem::read_symlink("/proc/self/exe", unknown).parent_path();
    return SharedLibrary::open(
        {.what = "the library that writes .vdb",
         .names = {folder / PROXIMA_VDB_LIBRARY,
                   folder / PROXIMA_LIBRARY_FOLDER / "proxima" / PROXIMA_VDB_LIBRARY},
         .named = {},
         .advice = "build the program where OpenVDB is (Debian's libopenvdb-dev), or write .npy or "
                   ".vti"});
}

} // namespace

std::uint64_t vdb_bytes(const PointGrid& grid) noexcept
{
    const auto leaves = [](std::uint64_t points) { return (points + 7) / 8; };
    constexpr std::uint64_t leaf_bytes = sizeof(float) * 8 * 8 * 8 + 256;
    return leaves(grid.size[0]) * leaves(grid.size[1]) * leaves(grid.size[2]) * leaf_bytes;
}

Result<WriteVdb*> vdb_writer(const std::string& path)
{
    static const Result<SharedLibrary> library = open_vdb_library();
    if (!library) return fail(ErrorCode::unsupported_format, library.error().message, path);
    WriteVdb* writer = nullptr;
    SymbolTable symbols(*library);
    symbols.need(writer, write_vdb_name);
    if (Status found = symbols.finish("it is of another version"); !found)
        return tl::unexpected(found.error());
    return writer;
}

Status write_vdb(const PointGrid& grid, std::span<const double> distances, double band,
                 const std::string& path, Progress* progress)
{
    const auto writer = vdb_writer(path);
    if (!writer) return tl::unexpected(writer.error());
    Status status;
    (*writer)(grid, distances, band, path, progress, status);
    return status;
}

} // namespace proxima
