#include "distributed/mesh_slice.h"
#include "mesh/io/ply_header.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

namespace proxima {

namespace {

using detail::PlyElement;
using detail::PlyProperty;
using detail::PlyType;

static_assert(std::endian::native == std::endian::little, "values are copied as they are");

/// Where values lie in a file whose records all have one size.
struct PlyLayout {
    std::uint64_t vertex_count = 0;
    std::uint64_t vertex_start = 0;
    std::uint64_t vertex_bytes = 0;
    std::array<std::uint64_t, 3> coordinate_offset = {};
    std::array<PlyType, 3> coordinate_type = {};
    std::uint64_t face_count = 0;
    std::uint64_t face_start = 0;
    std::uint64_t face_bytes = 0;
    std::uint64_t length_offset = 0;
    PlyType length_type{};
    PlyType corner_type{};
};

/// A file that every rank has open. Collective to open and to close.
class SharedFile {
public:
    explicit SharedFile(const std::string& path)
    {
        is_open_ = MPI_File_open(MPI_COMM_WORLD, path.c_str(), MPI_MODE_RDONLY, MPI_INFO_NULL,
                                 &file_) == MPI_SUCCESS;
    }
    ~SharedFile()
    {
        if (is_open_) MPI_File_close(&file_);
    }
    SharedFile(const SharedFile&) = delete;
    SharedFile& operator=(const SharedFile&) = delete;

    [[nodiscard]] bool is_open() const noexcept { return is_open_; }

    [[nodiscard]] std::uint64_t bytes() const
    {
        MPI_Offset size = 0;
        return MPI_File_get_size(file_, &size) == MPI_SUCCESS ? static_cast<std::uint64_t>(size)
                                                              : 0;
    }

    /// False where the file ends before, or cannot be read. Not collective.
    [[nodiscard]] bool read(std::uint64_t offset, char* to, std::uint64_t count)
    {
        constexpr std::uint64_t most = std::uint64_t{1} << 28U;
        while (count != 0) {
            const auto part = static_cast<int>(std::min(count, most));
            MPI_Status status;
            int got = 0;
            if (MPI_File_read_at(file_, static_cast<MPI_Offset>(offset), to, part, MPI_BYTE,
                                 &status) != MPI_SUCCESS ||
                MPI_Get_count(&status, MPI_BYTE, &got) != MPI_SUCCESS || got != part) {
                return false;
            }
            offset += static_cast<std::uint64_t>(part);
            to += part;
            count -= static_cast<std::uint64_t>(part);
        }
        return true;
    }

private:
    MPI_File file_ = MPI_FILE_NULL;
    bool is_open_ = false;
};

template <class T>
T value_at(const char* from) noexcept
{
    T value;
    std::memcpy(&value, from, sizeof(T));
    return value;
}

double coordinate_at(const char* from, PlyType type) noexcept
{
    return type == PlyType::float32 ? double{value_at<float>(from)} : value_at<double>(from);
}

std::int64_t integer_at(const char* from, PlyType type) noexcept
{
    switch (type) {
    case PlyType::int8:
        return value_at<std::int8_t>(from);
    case PlyType::uint8:
        return value_at<std::uint8_t>(from);
    case PlyType::int16:
        return value_at<std::int16_t>(from);
    case PlyType::uint16:
        return value_at<std::uint16_t>(from);
    case PlyType::int32:
        return value_at<std::int32_t>(from);
    default:
        return value_at<std::uint32_t>(from);
    }
}

bool is_integer(PlyType type) noexcept
{
    return type != PlyType::float32 && type != PlyType::float64;
}

Status place_vertices(const PlyElement& element, PlyLayout& layout)
{
    int found = 0;
    for (const PlyProperty& property : element.properties) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (property.name != std::string_view("xyz").substr(axis, 1)) continue;
            if (property.length_type || is_integer(property.type)) {
                return fail(ErrorCode::unsupported_format,
                            "x, y and z must be float or double for proxima-mpi");
            }
            layout.coordinate_offset[axis] = layout.vertex_bytes;
            layout.coordinate_type[axis] = property.type;
            ++found;
        }
        if (property.length_type) {
            return fail(ErrorCode::unsupported_format,
                        "vertices with lists have no fixed size: proxima-mpi reads none");
        }
        layout.vertex_bytes += size_of(property.type);
    }
    if (found == 3) return {};
    return fail(ErrorCode::malformed_file, "the element vertex must have x, y and z, each once");
}

Status place_faces(const PlyElement& element, PlyLayout& layout)
{
    int lists = 0;
    for (const PlyProperty& property : element.properties) {
        if (!property.length_type) {
            layout.face_bytes += size_of(property.type);
            continue;
        }
        if (++lists > 1 || !is_integer(property.type) || !is_integer(*property.length_type) ||
            (property.name != "vertex_indices" && property.name != "vertex_index")) {
            return fail(ErrorCode::unsupported_format,
                        "faces must have one list, vertex_indices, for proxima-mpi");
        }
        layout.length_offset = layout.face_bytes;
        layout.length_type = *property.length_type;
        layout.corner_type = property.type;
        layout.face_bytes += size_of(*property.length_type) + 3 * size_of(property.type);
    }
    if (lists == 1) return {};
    return fail(ErrorCode::malformed_file, "the element face has no list vertex_indices");
}

/// The layout of a file of `bytes` bytes that begins with `text`, header and all.
Result<PlyLayout> layout_of(const std::string& name, std::string_view text, std::uint64_t bytes)
{
    const auto header = detail::read_ply_header({name, text});
    if (!header) return tl::unexpected(header.error());
    if (header->body_kind != detail::PlyBody::little_endian) {
        return fail(ErrorCode::unsupported_format,
                    "proxima-mpi reads binary little-endian PLY: write the file as such");
    }
    PlyLayout layout;
    std::uint64_t offset = text.size() - header->body.size();
    bool has_faces = false;
    for (const PlyElement& element : header->elements) {
        if (element.count > std::uint64_t{1} << 48U) {
            return fail(ErrorCode::malformed_file, "the header promises more than 2^48 elements");
        }
        Status status;
        std::uint64_t size = 0;
        if (element.name == "vertex") {
            layout.vertex_count = element.count;
            layout.vertex_start = offset;
            status = place_vertices(element, layout);
            size = layout.vertex_bytes;
        } else if (element.name == "face") {
            layout.face_count = element.count;
            layout.face_start = offset;
            status = place_faces(element, layout);
            size = layout.face_bytes;
            has_faces = true;
        } else if (element.count != 0) {
            status = fail(ErrorCode::unsupported_format,
                          "proxima-mpi reads files of vertices and faces alone: leave out others");
        }
        if (!status) return tl::unexpected(status.error());
        offset += element.count * size;
    }
    if (!has_faces || layout.face_count == 0) {
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

class SliceReader {
public:
    SliceReader(std::string name, SharedFile& file, World& world)
        : name_(std::move(name)), file_(file), world_(world)
    {}

    Result<MeshSlice> read()
    {
        Status status = world_.agree_on([&] { return read_layout(); });
        if (status) status = world_.agree_on([&] { return read_triangles(); });
        if (status) status = world_.agree_on([&] { return read_vertices(); });
        if (!status) return tl::unexpected(status.error());
        auto positions = fetch_vertices();
        if (!positions) return tl::unexpected(positions.error());
        status =
            world_.agree_on([&] { return assemble(triangles_, std::move(*positions), slice_); });
        if (!status) return tl::unexpected(status.error());
        return std::move(slice_);
    }

private:
    Status read_layout()
    {
        constexpr std::uint64_t most = 1U << 16U; // a header has a few hundred bytes
        const std::uint64_t bytes = file_.bytes();
        std::string text(std::min(bytes, most), '\0');
        if (!file_.read(0, text.data(), text.size())) return ends_early();
        const auto layout = layout_of(name_, text, bytes);
        if (!layout) {
            Error error = layout.error();
            if (error.where.empty()) error.where = name_;
            return tl::unexpected(error);
        }
        layout_ = *layout;
        return {};
    }

    Status read_triangles()
    {
        slice_.whole_triangles = layout_.face_count;
        const Share share = share_of(layout_.face_count, world_.rank(), world_.size());
        slice_.first_triangle = share.first;
        const std::uint64_t count = share.end - share.first;
        if (count > max_slice_triangles) {
            return fail(ErrorCode::limit_exceeded,
                        "a rank would have more than 2^29 triangles: use more ranks");
        }
        triangles_.reserve(count);
        return read_records(
            layout_.face_start, layout_.face_bytes, share,
            [&](std::uint64_t id, const char* record) { return add_triangle(id, record); });
    }

    Status add_triangle(std::uint64_t id, const char* record)
    {
        const char* at = record + layout_.length_offset;
        const std::int64_t length = integer_at(at, layout_.length_type);
        if (length != 3) {
            return fail(ErrorCode::unsupported_format,
                        concat("face ", id, " has ", length,
                               " corners: proxima-mpi reads triangles, triangulate the mesh"),
                        name_);
        }
        at += size_of(layout_.length_type);
        WholeCorners& corners = triangles_.emplace_back();
        for (std::uint64_t& corner : corners) {
            const std::int64_t index = integer_at(at, layout_.corner_type);
            if (index < 0 || static_cast<std::uint64_t>(index) >= layout_.vertex_count) {
                return fail(ErrorCode::malformed_file,
                            concat("face ", id, " uses vertex ", index, " but the file has ",
                                   layout_.vertex_count, ", counted from 0"),
                            name_);
            }
            corner = static_cast<std::uint64_t>(index);
            at += size_of(layout_.corner_type);
        }
        return {};
    }

    /// The share of the vertices that this rank hands to the others.
    Status read_vertices()
    {
        const Share share = share_of(layout_.vertex_count, world_.rank(), world_.size());
        own_.reserve(share.end - share.first);
        own_first_ = share.first;
        return read_records(layout_.vertex_start, layout_.vertex_bytes, share,
                            [&](std::uint64_t, const char* record) -> Status {
                                Position& position = own_.emplace_back();
                                for (std::size_t axis = 0; axis < 3; ++axis) {
                                    position[axis] =
                                        coordinate_at(record + layout_.coordinate_offset[axis],
                                                      layout_.coordinate_type[axis]);
                                }
                                return {};
                            });
    }

    template <class Take>
    Status read_records(std::uint64_t start, std::uint64_t bytes, const Share& share,
                        const Take& take)
    {
        constexpr std::uint64_t block = 1U << 16U;
        std::vector<char> buffer(bytes * std::min(block, share.end - share.first));
        StageSteps steps(&world_.progress(), "reading", share.end - share.first, 1);
        for (std::uint64_t first = share.first; first < share.end; first += block) {
            const std::uint64_t count = std::min(block, share.end - first);
            if (!file_.read(start + first * bytes, buffer.data(), count * bytes)) {
                return ends_early();
            }
            for (std::uint64_t i = 0; i < count; ++i) {
                const Status status = take(first + i, buffer.data() + i * bytes);
                if (!status) return status;
            }
            if (!steps.done(count)) return cancelled("reading", name_);
        }
        return {};
    }

    /// Asks the ranks that read them for the positions of slice_.vertices.
    Result<std::vector<Vec3>> fetch_vertices()
    {
        const auto ranks = static_cast<std::size_t>(world_.size());
        std::vector<std::vector<std::uint64_t>> asked(ranks);
        Status status = world_.agree_on([&]() -> Status {
            slice_.vertices = used_vertices(triangles_);
            auto from = slice_.vertices.begin();
            for (std::size_t r = 0; r < ranks; ++r) {
                const Share share =
                    share_of(layout_.vertex_count, static_cast<int>(r), world_.size());
                const auto end = std::lower_bound(from, slice_.vertices.end(), share.end);
                asked[r].assign(from, end);
                from = end;
            }
            return {};
        });
        if (!status) return tl::unexpected(status.error());
        const auto wanted = world_.exchange(std::move(asked));
        if (!wanted) return tl::unexpected(wanted.error());
        std::vector<std::vector<Position>> answers(ranks);
        status = world_.agree_on([&]() -> Status {
            for (std::size_t r = 0; r < ranks; ++r) {
                for (std::size_t i = wanted->first[r]; i < wanted->first[r + 1]; ++i) {
                    answers[r].push_back(own_[wanted->items[i] - own_first_]);
                }
            }
            std::vector<Position>().swap(own_);
            return {};
        });
        if (!status) return tl::unexpected(status.error());
        const auto received = world_.exchange(std::move(answers));
        if (!received) return tl::unexpected(received.error());
        std::vector<Vec3> positions;
        status = world_.agree_on([&]() -> Status {
            positions.reserve(received->items.size());
            for (const Position& at : received->items) positions.emplace_back(at[0], at[1], at[2]);
            return {};
        });
        if (!status) return tl::unexpected(status.error());
        return positions;
    }

    [[nodiscard]] tl::unexpected<Error> ends_early() const
    {
        return fail(ErrorCode::malformed_file,
                    "the file could not be read to its end: it is cut off or changes", name_);
    }

    using Position = std::array<double, 3>;

    std::string name_;
    SharedFile& file_;
    World& world_;
    PlyLayout layout_;
    MeshSlice slice_;
    std::vector<WholeCorners> triangles_;
    std::vector<Position> own_;
    std::uint64_t own_first_ = 0;
};

} // namespace

Result<MeshSlice> read_ply_slice(const std::filesystem::path& path, World& world)
{
    SharedFile file(path.string());
    const Status status = world.agree_on([&]() -> Status {
        if (file.is_open()) return {};
        return fail(ErrorCode::file_not_found,
                    concat("cannot be opened for reading on rank ", world.rank()), path.string());
    });
    if (!status) return tl::unexpected(status.error());
    return SliceReader(path.string(), file, world).read();
}

} // namespace proxima
