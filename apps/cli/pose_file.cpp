#include "cli/pose_file.h"

#include "base/file_extension.h"
#include "base/text.h"
#include "cli/number_table.h"

#include <cctype>
#include <fstream>
#include <span>

namespace proxima {

namespace {

constexpr std::string_view pose_columns = "r00,r01,r02,tx,r10,r11,r12,ty,r20,r21,r22,tz";

/// Whether the first line names columns. \pre read_number_table took the file
bool has_header(const std::string& path)
{
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    const std::size_t first = line.find_first_not_of(" \t\xEF\xBB\xBF");
    return first != std::string::npos && std::isalpha(static_cast<unsigned char>(line[first])) != 0;
}

} // namespace

Result<std::vector<RigidTransform>> read_poses(const std::string& path, Progress* progress)
{
    const auto table = read_number_table(path, pose_columns, {.execution = {.progress = progress}});
    if (!table) return tl::unexpected(table.error());
    const bool binary = lower_case_extension(path) == ".npy";
    const std::size_t first_line = binary ? 0 : has_header(path) ? 2 : 1;
    std::vector<RigidTransform> poses;
    poses.reserve(table->rows());
    for (std::size_t i = 0; i < table->rows(); ++i) {
        const std::span<const double, 12> row(table->values.data() + 12 * i, 12);
        auto pose = make_rigid_transform(row);
        if (!pose) {
            Error error = pose.error();
            error.where = concat(path, binary ? ", row " : ":", first_line + i);
            return tl::unexpected(std::move(error));
        }
        poses.push_back(*pose);
    }
    return poses;
}

} // namespace proxima
