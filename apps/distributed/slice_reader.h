// Reads a rank's part of a mesh from records that all have one size, wherever they lie.
#pragma once

#include "distributed/mesh_slice.h"

#include <array>
#include <cstdint>
#include <mpi.h>
#include <optional>
#include <string>

namespace proxima {

/// A file that every rank opens for itself; nothing of it is collective.
class SharedFile {
public:
    explicit SharedFile(const std::string& path);
    ~SharedFile();
    SharedFile(const SharedFile&) = delete;
    SharedFile& operator=(const SharedFile&) = delete;

    [[nodiscard]] bool is_open() const noexcept { return is_open_; }

    /// 0 where the system does not say.
    [[nodiscard]] std::uint64_t bytes() const;

    /// False where the file ends before, or cannot be read.
    [[nodiscard]] bool read(std::uint64_t offset, char* to, std::uint64_t count);

private:
    MPI_File file_ = MPI_FILE_NULL;
    bool is_open_ = false;
};

/// Little-endian numbers.
enum class NumberType : std::uint8_t {
    int8,
    uint8,
    int16,
    uint16,
    int32,
    uint32,
    int64,
    uint64,
    float32,
    float64
};

[[nodiscard]] std::uint64_t bytes_of(NumberType type) noexcept;

/// Records one after the other.
struct RecordArray {
    SharedFile* file = nullptr;
    std::string name; ///< of the file, for messages
    std::uint64_t start = 0;
    std::uint64_t bytes = 0; ///< of a record
    std::uint64_t count = 0;
};

/// Where a number lies in its record.
struct NumberPlace {
    std::uint64_t offset = 0;
    NumberType type{};
};

/// Vertices, and triangles by the numbers of their corners.
struct MeshRecords {
    RecordArray vertices;
    std::array<NumberPlace, 3> coordinates; ///< float32 or float64
    RecordArray triangles;
    NumberPlace corners;                 ///< the first of three, of whole numbers
    std::optional<NumberPlace> length{}; ///< a number that must be 3
};

/// Checks that all ranks can read a file, and that it has the same content on each: its size, and
/// 64 KiB at 16 places from the first to the last byte. Collective.
[[nodiscard]] Status check_file(SharedFile& file, const std::string& name, World& world);

/// The error of a file that ended before its size said so.
[[nodiscard]] tl::unexpected<Error> ends_early(const std::string& name);

/// Reads this rank's triangles and its share of the vertices, and has the others sent by the ranks
/// that read them. Collective.
[[nodiscard]] Result<MeshSlice> read_slice(const MeshRecords& records, World& world);

} // namespace proxima
