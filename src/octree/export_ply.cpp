#include "base/output_file.h"
#include "base/text.h"
#include "octree/leaf_boxes.h"
#include "proxima/octree_io.h"

#include <array>
#include <bit>
#include <cstring>
#include <limits>

namespace proxima {

namespace {

using Colour = std::array<std::uint8_t, 3>;

Colour colour(CellClass type) noexcept
{
    switch (type) {
    case CellClass::outer:
        return {170, 200, 230};
    case CellClass::inner:
        return {240, 170, 60};
    case CellClass::boundary:
        return {200, 60, 60};
    case CellClass::unclassified:
        break;
    }
    return {150, 150, 150};
}

/// Corners of the six sides, counter-clockwise seen from outside.
constexpr std::array<std::array<std::uint32_t, 4>, 6> sides = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

template <class T>
void append(std::string& bytes, const T& value)
{
    const auto at = bytes.size();
    bytes.resize(at + sizeof value);
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

void append_colour(std::string& bytes, CellClass type)
{
    for (const std::uint8_t part : colour(type)) append(bytes, part);
}

} // namespace

Status export_ply(const Octree& octree, const std::filesystem::path& path,
                  const ExportOptions& options)
{
    constexpr std::size_t bytes_per_vertex = 3 * sizeof(double) + 3;
    constexpr std::size_t bytes_per_face = 1 + 4 * sizeof(std::uint32_t) + 3 + 2;
    const auto found = leaf_boxes(octree, LeafChoice::all, options.execution.progress);
    if (!found) return tl::unexpected(found.error());
    const std::vector<LeafBox>& leaves = *found;
    if (8 * leaves.size() > std::numeric_limits<std::uint32_t>::max()) {
        return fail(ErrorCode::limit_exceeded,
                    concat(leaves.size(), " leaves have more corners than .ply can number: export "
                                          "as .vtu or .htg"),
                    path.string());
    }
    auto file =
        OutputFile::create(path, {options.execution.progress,
                                  leaves.size() * (8 * bytes_per_vertex + 6 * bytes_per_face)});
    if (!file) return tl::unexpected<Error>(file.error());
    const char* const order = std::endian::native == std::endian::little ? "little" : "big";
    Status status = file->write(
        concat("ply\nformat binary_", order,
               "_endian 1.0\ncomment leaves of an octree; class: 0 outer, 1 inner, 2 boundary, 3 "
               "unclassified\nelement vertex ",
               8 * leaves.size(),
               "\nproperty double x\nproperty double y\nproperty double z\n"
               "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face ",
               6 * leaves.size(),
               "\nproperty list uchar uint vertex_indices\n"
               "property uchar red\nproperty uchar green\nproperty uchar blue\n"
               "property uchar class\nproperty uchar depth\nend_header\n"));
    if (!status) return status;
    std::string bytes;
    for (const LeafBox& leaf : leaves) {
        bytes.clear();
        for (int corner = 0; corner < 8; ++corner) {
            for (const double coordinate : corner_position(octree, leaf, corner)) {
                append(bytes, coordinate);
            }
            append_colour(bytes, leaf.type);
        }
        if (status = file->write(bytes); !status) return status;
    }
    std::uint32_t first = 0;
    for (const LeafBox& leaf : leaves) {
        bytes.clear();
        for (const auto& side : sides) {
            append(bytes, std::uint8_t{4});
            for (const std::uint32_t corner : side) append(bytes, first + corner);
            append_colour(bytes, leaf.type);
            append(bytes, static_cast<std::uint8_t>(leaf.type));
            append(bytes, leaf.depth);
        }
        if (status = file->write(bytes); !status) return status;
        first += 8;
    }
    return file->commit();
}

} // namespace proxima
