#include "distributed/slice_reader.h"
#include "mesh/io/ply_header.h"

#include <algorithm>

namespace proxima {

namespace {

using detail::PlyElement;
using detail::PlyProperty;
using detail::PlyType;

NumberType number_type(PlyType type) noexcept
{
    switch (type) {
    case PlyType::int8:
        return NumberType::int8;
    case PlyType::uint8:
        return NumberType::uint8;
    case PlyType::int16:
        return NumberType::int16;
    case PlyType::uint16:
        return NumberType::uint16;
    case PlyType::int32:
        return NumberType::int32;
    case PlyType::uint32:
        return NumberType::uint32;
    case PlyType::float32:
        return NumberType::float32;
    default:
        return NumberType::float64;
    }
}

bool is_integer(PlyType type) noexcept
{
    return type != PlyType::float32 && type != PlyType::float64;
}

Status place_vertices(const PlyElement& element, MeshRecords& layout)
{
    constexpr std::string_view once = "the element vertex must have x, y and z, each once";
    unsigned found = 0; // a bit of each axis
    for (const PlyProperty& property : element.properties) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (property.name != std::string_view("xyz").substr(axis, 1)) continue;
            if (property.length_type || is_integer(property.type)) {
                return fail(ErrorCode::unsupported_format,
                            "x, y and z must be float or double for proxima-mpi");
            }
            layout.coordinates[axis] = {layout.vertices.bytes, number_type(property.type)};
            if ((found >> axis & 1U) != 0)
                return fail(ErrorCode::malformed_file, std::string(once));
            found |= 1U << axis;
        }
        if (property.length_type) {
            return fail(ErrorCode::unsupported_format,
                        "vertices with lists have no fixed size: proxima-mpi reads none");
        }
        layout.vertices.bytes += size_of(property.type);
    }
    if (found == 7) return {};
    return fail(ErrorCode::malformed_file, std::string(once));
}

Status place_faces(const PlyElement& element, MeshRecords& layout)
{
    int lists = 0;
    for (const PlyProperty& property : element.properties) {
        if (!property.length_type) {
            layout.triangles.bytes += size_of(property.type);
            continue;
        }
        if (++lists > 1 || !is_integer(property.type) || !is_integer(*property.length_type) ||
            (property.name != "vertex_indices" && property.name != "vertex_index")) {
            return fail(ErrorCode::unsupported_format,
                        "faces must have one list, vertex_indices, for proxima-mpi");
        }
        layout.length = {layout.triangles.bytes, number_type(*property.length_type)};
        layout.triangles.bytes += size_of(*property.length_type);
        layout.corners = {layout.triangles.bytes, number_type(property.type)};
        layout.triangles.bytes += 3 * size_of(property.type);
    }
    if (lists == 1) return {};
    return fail(ErrorCode::malformed_file, "the element face has no list vertex_indices");
}

/// The layout of a file of `bytes` bytes that begins with `text`, header and all.
Result<MeshRecords> layout_of(const std::string& name, std::string_view text, std::uint64_t bytes)
{
    const auto header = detail::read_ply_header({name, text});
    if (!header) return tl::unexpected(header.error());
    if (header->body_kind != detail::PlyBody::little_endian) {
        return fail(ErrorCode::unsupported_format,
                    "proxima-mpi reads binary little-endian PLY: write the file as such");
    }
    MeshRecords layout;
    std::uint64_t offset = text.size() - header->body.size();
    bool has_faces = false;
    for (const PlyElement& element : header->elements) {
        if (element.count > std::uint64_t{1} << 48U) {
            return fail(ErrorCode::malformed_file, "the header promises more than 2^48 elements");
        }
        Status status;
        std::uint64_t size = 0;
        if (element.name == "vertex") {
            layout.vertices.count = element.count;
            layout.vertices.start = offset;
            status = place_vertices(element, layout);
            size = layout.vertices.bytes;
        } else if (element.name == "face") {
            layout.triangles.count = element.count;
            layout.triangles.start = offset;
            status = place_faces(element, layout);
            size = layout.triangles.bytes;
            has_faces = true;
        } else if (element.count != 0) {
            status = fail(ErrorCode::unsupported_format,
                          "proxima-mpi reads files of vertices and faces alone: leave out others");
        }
        if (!status) return tl::unexpected(status.error());
        offset += element.count * size;
    }
    if (!has_faces || layout.triangles.count == 0) {
        return fail(ErrorCode::invalid_mesh, "the file has no triangles");
    }
    if (bytes == offset) return layout;
    if (bytes < offset) {
        return fail(ErrorCode::malformed_file,
                    concat("the file has ", bytes, " bytes, its header promises ", offset,
                           ": it is cut off, copy it again, or not all faces are triangles"));
    }
    return fail(ErrorCode::malformed_file,
                concat("the file has ", bytes, " bytes, its header promises ", offset,
                       " for triangles: proxima-mpi reads no other faces"));
}

/// Reads the header, of at most 16 MiB.
Status read_layout(const std::string& name, SharedFile& file, MeshRecords& records)
{
    const std::uint64_t bytes = file.bytes();
    Result<MeshRecords> layout;
    // A header has a few hundred bytes, but comments may make it long.
    for (std::uint64_t most = 1U << 16U; most <= 1U << 24U; most *= 16) {
        std::string text(std::min(bytes, most), '\0');
        if (!file.read(0, text.data(), text.size())) return ends_early(name);
        layout = layout_of(name, text, bytes);
        if (layout || text.size() == bytes) break;
    }
    if (!layout) {
        Error error = layout.error();
        if (error.where.empty()) error.where = name;
        return tl::unexpected(error);
    }
    records = std::move(*layout);
    for (RecordArray* const array : {&records.vertices, &records.triangles}) {
        array->file = &file;
        array->name = name;
    }
    return {};
}

} // namespace

Result<MeshSlice> read_ply_slice(const std::filesystem::path& path, World& world)
{
    SharedFile file(path.string());
    Status status = check_file(file, path.string(), world);
    if (!status) return tl::unexpected(status.error());
    MeshRecords records;
    status = world.agree_on([&] { return read_layout(path.string(), file, records); });
    if (!status) return tl::unexpected(status.error());
    return read_slice(records, world);
}

} // namespace proxima
