#include "cli/npy_header.h"
#include "distributed/slice_reader.h"

#include <algorithm>

namespace proxima {

namespace {

Result<NumberType> number_type(const NpyHeader& header)
{
    using enum NumberType;
    if (header.kind == NpyKind::real) {
        if (header.bytes_per_number == 4) return float32;
        if (header.bytes_per_number == 8) return float64;
        return fail(ErrorCode::unsupported_format, "coordinates must be float32 or float64");
    }
    const bool is_signed = header.kind == NpyKind::signed_whole;
    switch (header.bytes_per_number) {
    case 1:
        return is_signed ? int8 : uint8;
    case 2:
        return is_signed ? int16 : uint16;
    case 4:
        return is_signed ? int32 : uint32;
    default:
        return is_signed ? int64 : uint64;
    }
}

/// The rows of three numbers of a file. `is_real`: of coordinates, else of vertex numbers.
Result<NumberType> read_layout(SharedFile& file, bool is_real, RecordArray& rows)
{
    const std::uint64_t bytes = file.bytes();
    std::string text(std::min<std::uint64_t>(bytes, max_npy_header), '\0');
    if (!file.read(0, text.data(), text.size())) return ends_early(rows.name);
    const auto header = parse_npy_header(text);
    if (!header) return tl::unexpected(header.error());
    if (header->shape.size() != 2 || header->shape[1] != 3 ||
        (header->kind == NpyKind::real) != is_real) {
        return fail(ErrorCode::unsupported_format,
                    is_real ? "vertices must be an array of N x 3 real numbers"
                            : "triangles must be an array of N x 3 whole numbers");
    }
    if (header->big_endian || header->order != NpyOrder::rows_first) {
        return fail(ErrorCode::unsupported_format,
                    "the array must be little-endian and in C order: write it as such");
    }
    auto type = number_type(*header);
    if (!type) return type;
    rows.file = &file;
    rows.start = header->length;
    rows.bytes = 3 * bytes_of(*type);
    rows.count = header->shape[0];
    const std::uint64_t content = bytes - std::min<std::uint64_t>(bytes, header->length);
    if (content % rows.bytes == 0 && content / rows.bytes == rows.count) return type;
    return fail(ErrorCode::malformed_file,
                concat("the file has ", content, " bytes of numbers, its header promises ",
                       rows.count, " rows of ", rows.bytes, ": it is cut off, copy it again"));
}

Status read_layouts(SharedFile& vertices, SharedFile& triangles, MeshRecords& records)
{
    const auto located = [](Error error, const std::string& name) {
        if (error.where.empty()) error.where = name;
        return tl::unexpected(error);
    };
    const auto coordinate = read_layout(vertices, true, records.vertices);
    if (!coordinate) return located(coordinate.error(), records.vertices.name);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        records.coordinates[axis] = {axis * bytes_of(*coordinate), *coordinate};
    }
    const auto corner = read_layout(triangles, false, records.triangles);
    if (!corner) return located(corner.error(), records.triangles.name);
    records.corners = {0, *corner};
    if (records.triangles.count != 0) return {};
    return fail(ErrorCode::invalid_mesh, "the file has no triangles", records.triangles.name);
}

} // namespace

Result<MeshSlice> read_npy_slice(const std::filesystem::path& vertices,
                                 const std::filesystem::path& triangles, World& world)
{
    MeshRecords records;
    records.vertices.name = vertices.string();
    records.triangles.name = triangles.string();
    SharedFile vertex_file(records.vertices.name);
    SharedFile triangle_file(records.triangles.name);
    Status status = check_file(vertex_file, records.vertices.name, world);
    if (status) status = check_file(triangle_file, records.triangles.name, world);
    if (status) {
        status = world.agree_on([&] { return read_layouts(vertex_file, triangle_file, records); });
    }
    if (!status) return tl::unexpected(status.error());
    return read_slice(records, world);
}

} // namespace proxima
