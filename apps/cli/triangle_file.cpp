#include "cli/triangle_file.h"

#include "base/file_extension.h"
#include "base/output_file.h"
#include "base/text.h"
#include "cli/npy_header.h"
#include "cli/session.h"
#include "proxima/mesh_io.h"
#include "proxima/mesh_repair.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

namespace proxima {

namespace {

constexpr std::array mesh_extensions = {".obj", ".ply", ".off", ".stl"};

bool is_mesh_extension(const std::string& extension)
{
    return std::ranges::find(mesh_extensions, extension) != mesh_extensions.end();
}

std::string csv_of(std::span<const TriangleId> triangles)
{
    std::string text = "triangle\n";
    for (const TriangleId id : triangles) text += concat(to_index(id), '\n');
    return text;
}

std::string npy_of(std::span<const TriangleId> triangles)
{
    std::vector<double> numbers;
    numbers.reserve(triangles.size());
    for (const TriangleId id : triangles) numbers.push_back(to_index(id));
    const auto bytes = std::as_bytes(std::span(numbers));
    std::string text = npy_header(triangles.size(), 1);
    text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text;
}

} // namespace

Status check_mesh_file_format(const std::string& path)
{
    if (is_mesh_extension(lower_case_extension(path))) return {};
    return fail(ErrorCode::unsupported_format,
                "unknown extension: a mesh is written to .obj, .ply, .off or .stl", path);
}

Status check_triangle_file_format(const std::string& path)
{
    const std::string extension = lower_case_extension(path);
    if (path == to_stdout || extension == ".csv" || extension == ".npy" ||
        is_mesh_extension(extension))
        return {};
    return fail(ErrorCode::unsupported_format,
                "unknown extension: triangles are written as ids to .csv or .npy, as a mesh to "
                ".obj, .ply, .off or .stl",
                path);
}

Status write_triangle_file(const TriangleMesh& mesh, std::span<const TriangleId> triangles,
                           const std::string& path, Progress* progress)
{
    if (Status status = check_triangle_file_format(path); !status) return status;
    const std::string extension = lower_case_extension(path);
    if (is_mesh_extension(extension))
        return write_mesh(sub_mesh(mesh, triangles), path, {.execution = {.progress = progress}});
    if (path == to_stdout) {
        const std::string text = csv_of(triangles);
        std::fwrite(text.data(), 1, text.size(),
                    stdout); // what it did not take, finish_stdout says
        return {};
    }
    const std::string text = extension == ".csv" ? csv_of(triangles) : npy_of(triangles);
    auto file = OutputFile::create(path, {progress, text.size()});
    if (!file) return tl::unexpected(file.error());
    if (Status status = file->write(text); !status) return status;
    return file->commit();
}

} // namespace proxima
