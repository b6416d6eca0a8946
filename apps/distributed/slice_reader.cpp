#include "distributed/slice_reader.h"

#include "base/hash.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <span>
#include <system_error>

namespace proxima {

namespace {

static_assert(std::endian::native == std::endian::little, "values are copied as they are");

template <class T>
T value_at(const char* from) noexcept
{
    T value;
    std::memcpy(&value, from, sizeof(T));
    return value;
}

double coordinate_at(const char* from, NumberType type) noexcept
{
    return type == NumberType::float32 ? double{value_at<float>(from)} : value_at<double>(from);
}

/// Numbers beyond 2^63 are negative, which no vertex is.
std::int64_t integer_at(const char* from, NumberType type) noexcept
{
    switch (type) {
    case NumberType::int8:
        return value_at<std::int8_t>(from);
    case NumberType::uint8:
        return value_at<std::uint8_t>(from);
    case NumberType::int16:
        return value_at<std::int16_t>(from);
    case NumberType::uint16:
        return value_at<std::uint16_t>(from);
    case NumberType::int32:
        return value_at<std::int32_t>(from);
    case NumberType::uint32:
        return value_at<std::uint32_t>(from);
    default:
        return value_at<std::int64_t>(from);
    }
}

class SliceReader {
public:
    SliceReader(const MeshRecords& layout, World& world) : layout_(layout), world_(world) {}

    Result<MeshSlice> read()
    {
        Status status = world_.agree_on([&] { return read_triangles(); });
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
    Status read_triangles()
    {
        slice_.name = layout_.vertices.name;
        slice_.whole_triangles = layout_.triangles.count;
        const Share share = share_of(layout_.triangles.count, world_.rank(), world_.size());
        slice_.first_triangle = share.first;
        const std::uint64_t count = share.end - share.first;
        if (count > max_slice_triangles) {
            return fail(ErrorCode::limit_exceeded,
                        "a rank would have more than 2^29 triangles: use more ranks");
        }
        triangles_.reserve(count);
        return read_records(layout_.triangles, share, [&](std::uint64_t id, const char* record) {
            return add_triangle(id, record);
        });
    }

    Status add_triangle(std::uint64_t id, const char* record)
    {
        if (layout_.length) {
            const std::int64_t length =
                integer_at(record + layout_.length->offset, layout_.length->type);
            if (length != 3) {
                return fail(ErrorCode::unsupported_format,
                            concat("face ", id, " has ", length,
                                   " corners: proxima-mpi reads triangles, triangulate the mesh"),
                            layout_.triangles.name);
            }
        }
        const char* at = record + layout_.corners.offset;
        WholeCorners& corners = triangles_.emplace_back();
        for (std::uint64_t& corner : corners) {
            const std::int64_t index = integer_at(at, layout_.corners.type);
            if (index < 0 || static_cast<std::uint64_t>(index) >= layout_.vertices.count) {
                return fail(ErrorCode::malformed_file,
                            concat("face ", id, " uses vertex ", index, " but there are ",
                                   layout_.vertices.count, ", counted from 0"),
                            layout_.triangles.name);
            }
            corner = static_cast<std::uint64_t>(index);
            at += bytes_of(layout_.corners.type);
        }
        return {};
    }

    /// The share of the vertices that this rank hands to the others.
    Status read_vertices()
    {
        const Share share = share_of(layout_.vertices.count, world_.rank(), world_.size());
        own_.reserve(share.end - share.first);
        own_first_ = share.first;
        return read_records(
            layout_.vertices, share, [&](std::uint64_t, const char* record) -> Status {
                Position& position = own_.emplace_back();
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const NumberPlace& place = layout_.coordinates[axis];
                    position[axis] = coordinate_at(record + place.offset, place.type);
                }
                return {};
            });
    }

    template <class Take>
    Status read_records(const RecordArray& array, const Share& share, const Take& take)
    {
        constexpr std::uint64_t block = 1U << 16U;
        const std::uint64_t bytes = array.bytes;
        std::vector<char> buffer(bytes * std::min(block, share.end - share.first));
        StageSteps steps(&world_.progress(), "reading", share.end - share.first, 1);
        for (std::uint64_t first = share.first; first < share.end; first += block) {
            const std::uint64_t count = std::min(block, share.end - first);
            if (!array.file->read(array.start + first * bytes, buffer.data(), count * bytes)) {
                return ends_early(array.name);
            }
            for (std::uint64_t i = 0; i < count; ++i) {
                Status status = take(first + i, buffer.data() + i * bytes);
                if (!status) return status;
            }
            if (!steps.done(count)) return cancelled("reading", array.name);
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
                    share_of(layout_.vertices.count, static_cast<int>(r), world_.size());
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

    using Position = std::array<double, 3>;

    const MeshRecords& layout_;
    World& world_;
    MeshSlice slice_;
    std::vector<WholeCorners> triangles_;
    std::vector<Position> own_;
    std::uint64_t own_first_ = 0;
};

} // namespace

SharedFile::SharedFile(const std::string& path)
{
    // By each rank for itself: where one alone cannot, the others would wait for it for ever.
    is_open_ = MPI_File_open(MPI_COMM_SELF, path.c_str(), MPI_MODE_RDONLY, MPI_INFO_NULL, &file_) ==
               MPI_SUCCESS;
}

SharedFile::~SharedFile()
{
    if (is_open_) MPI_File_close(&file_);
}

std::uint64_t SharedFile::bytes() const
{
    MPI_Offset size = 0;
    return MPI_File_get_size(file_, &size) == MPI_SUCCESS ? static_cast<std::uint64_t>(size) : 0;
}

bool SharedFile::read(std::uint64_t offset, char* to, std::uint64_t count)
{
    constexpr std::uint64_t most = std::uint64_t{1} << 28U;
    while (count != 0) {
        const auto part = static_cast<int>(std::min(count, most));
        MPI_Status status;
        int got = 0;
        if (MPI_File_read_at(file_, static_cast<MPI_Offset>(offset), to, part, MPI_BYTE, &status) !=
                MPI_SUCCESS ||
            MPI_Get_count(&status, MPI_BYTE, &got) != MPI_SUCCESS || got != part) {
            return false;
        }
        offset += static_cast<std::uint64_t>(part);
        to += part;
        count -= static_cast<std::uint64_t>(part);
    }
    return true;
}

std::uint64_t bytes_of(NumberType type) noexcept
{
    constexpr std::array<std::uint8_t, 10> bytes = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return bytes[static_cast<std::size_t>(type)];
}

Status check_file(SharedFile& file, const std::string& name, World& world)
{
    constexpr std::uint64_t places = 16;
    constexpr std::uint64_t most = 1U << 16U;
    std::uint64_t hash = 0;
    const Status status = world.agree_on([&]() -> Status {
        std::error_code error;
        if (std::filesystem::is_directory(name, error))
            return fail(ErrorCode::file_not_found, "this is a folder: name a file in it", name);
        if (!file.is_open()) {
            return fail(ErrorCode::file_not_found,
                        concat("cannot be opened for reading on rank ", world.rank()), name);
        }
        const std::uint64_t bytes = file.bytes();
        std::vector<char> block(std::min(bytes, most));
        hash = bytes;
        for (std::uint64_t i = 0; i < places; ++i) {
            const std::uint64_t start = (bytes - block.size()) / (places - 1) * i;
            const std::uint64_t at = i + 1 < places ? start : bytes - block.size();
            if (!file.read(at, block.data(), block.size())) return ends_early(name);
            hash = hash_bytes(std::as_bytes(std::span(block)), hash);
        }
        return {};
    });
    return status ? world.expect_same(hash, name) : status;
}

tl::unexpected<Error> ends_early(const std::string& name)
{
    return fail(ErrorCode::malformed_file,
                "the file could not be read to its end: it is cut off or changes", name);
}

Result<MeshSlice> read_slice(const MeshRecords& records, World& world)
{
    return SliceReader(records, world).read();
}

} // namespace proxima
