#include "cli/vdb_file.h"

#include "cli/program_library.h"

namespace proxima {

std::uint64_t vdb_bytes(const PointGrid& grid) noexcept
{
    const auto leaves = [](std::uint64_t points) { return (points + 7) / 8; };
    constexpr std::uint64_t leaf_bytes = sizeof(float) * 8 * 8 * 8 + 256;
    return leaves(grid.size[0]) * leaves(grid.size[1]) * leaves(grid.size[2]) * leaf_bytes;
}

Result<WriteVdb*> vdb_writer(const std::string& path)
{
    static const auto library = open_function<WriteVdb>(
        program_library("vdb", "the library that writes .vdb",
                        "build the program where OpenVDB is (Debian's libopenvdb-dev), or write "
                        ".npy or .vti"),
        write_vdb_name);
    if (!library) return fail(ErrorCode::unsupported_format, library.error().message, path);
    return library->call;
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
