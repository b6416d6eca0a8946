// Files of named arrays that are used in place: versioned, checksummed, read or mapped.
//
//     header   magic 8 | byte order mark 4 | version 4 | section count 4 | 0 4 | file bytes 8 |
//              checksum of header and table 8
//     table    per section: id 4 | element bytes 4 | offset 8 | bytes 8 | checksum 8
//     sections each at a multiple of 128 bytes, zeros between
//
// Numbers are in the byte order of the writer, which a reader of the other order refuses. Checksums
// are XXH3 64 bits: they find damage, not malice; who uses the arrays checks what they say.
#pragma once

#include "base/output_file.h"
#include "proxima/execution.h"
#include "proxima/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace proxima {

/// What a file says it is: eight characters, and the newest version that can be read.
struct FileFormat {
    std::array<char, 8> magic{};
    std::uint32_t version = 1;
    const char* name = ""; ///< in messages: "octree file"
};

/// Sections begin at multiples of it: two cache lines, which blocks of mesh indexes are aligned to.
inline constexpr std::size_t section_alignment = 128;

/// One array to be written. The bytes are not copied.
struct BinarySection {
    std::uint32_t id = 0;
    std::uint32_t element_bytes = 1;
    std::span<const std::byte> bytes;
};

/// The array as a section. T has no padding, so that equal arrays make equal files.
template <class T>
requires std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>
[[nodiscard]] BinarySection binary_section(std::uint32_t id, std::span<const T> array) noexcept
{
    return {id, static_cast<std::uint32_t>(sizeof(T)), std::as_bytes(array)};
}

/// Writes the sections in order, whole or not at all. Same sections, same bytes.
/// `progress` sees the stages "checksums" and "writing", steps are bytes. Errors:
/// file_not_writable, cancelled.
[[nodiscard]] Status write_binary_file(const std::filesystem::path& path, const FileFormat& format,
                                       std::span<const BinarySection> sections,
                                       Progress* progress = nullptr);

/// An array that is still to be written.
struct SectionSize {
    std::uint32_t id = 0;
    std::uint32_t element_bytes = 1;
    std::uint64_t bytes = 0;
};

/// Writes the file of write_binary_file, byte for byte, without having its sections in memory: their
/// bytes come one after the other. Whole or not at all; the destination must be a regular file.
class BinaryFileWriter {
public:
    /// `progress` sees the stage "writing". Errors: file_not_writable, limit_exceeded.
    [[nodiscard]] static Result<BinaryFileWriter> create(const std::filesystem::path& path,
                                                         const FileFormat& format,
                                                         std::span<const SectionSize> sections,
                                                         Progress* progress = nullptr);

    BinaryFileWriter(BinaryFileWriter&&) noexcept;
    BinaryFileWriter& operator=(BinaryFileWriter&&) noexcept;
    BinaryFileWriter(const BinaryFileWriter&) = delete;
    BinaryFileWriter& operator=(const BinaryFileWriter&) = delete;
    ~BinaryFileWriter();

    /// The next bytes of the sections. Errors: file_not_writable, cancelled; the same one from then
    /// on. \pre no more bytes than the sections have
    [[nodiscard]] Status write(std::span<const std::byte> bytes);

    /// \pre all bytes were written, or write() failed
    [[nodiscard]] Status commit();

private:
    struct State;
    explicit BinaryFileWriter(std::unique_ptr<State> state) noexcept;
    std::unique_ptr<State> state_;
};

/// Sets a file's checksums to those of its bytes, as far as it has a table; what a crafted file has
/// done. For tests of readers, whose damaged files checksums would refuse before anything else.
void reseal_binary_file(std::span<std::byte> bytes) noexcept;

/// How a file is opened.
struct BinaryFileOptions {
    Verification verify = Verification::full;
    FileAccess access = FileAccess::read;
    MemoryBudget budget = {};     ///< of the bytes that are read
    Progress* progress = nullptr; ///< stages "loading file" and "checksums", steps are bytes
};

/// A file of sections in memory, read-only; copies share it. Thread safe.
class BinaryFile {
public:
    /// Reads or maps the file and checks it. Errors: file_not_found; unsupported_format for a
    /// foreign file, a newer version or the other byte order; malformed_file where it is truncated,
    /// longer than it says, or a checksum or an offset is wrong; budget_exceeded; cancelled.
    [[nodiscard]] static Result<BinaryFile> open(const std::filesystem::path& path,
                                                 const FileFormat& format,
                                                 const BinaryFileOptions& options);

    /// Checks a file whose bytes are in memory, where `storage` keeps them alive. Messages have `name` in
    /// place of a path. Errors: those of open() but for file_not_found and budget_exceeded, and
    /// invalid_argument where the bytes do not begin at a multiple of section_alignment.
    [[nodiscard]] static Result<BinaryFile> read(std::span<const std::byte> bytes,
                                                 std::shared_ptr<const void> storage,
                                                 const std::string& name, const FileFormat& format,
                                                 Verification verification,
                                                 Progress* progress = nullptr);

    /// The array in place. Error malformed_file where it is missing or has other elements.
    template <class T>
    requires std::is_trivially_copyable_v<T>
    [[nodiscard]] Result<std::span<const T>> section(std::uint32_t id) const
    {
        auto bytes = section_bytes(id, sizeof(T));
        if (!bytes) return tl::unexpected<Error>(bytes.error());
        return std::span<const T>(static_cast<const T*>(static_cast<const void*>(bytes->data())),
                                  bytes->size() / sizeof(T));
    }

    [[nodiscard]] std::uint32_t version() const noexcept { return version_; }

    /// Keeps the bytes alive.
    [[nodiscard]] std::shared_ptr<const void> storage() const noexcept { return storage_; }

private:
    struct Entry {
        std::uint32_t id = 0;
        std::uint32_t element_bytes = 0;
        std::span<const std::byte> bytes;
    };

    [[nodiscard]] Result<std::span<const std::byte>> section_bytes(std::uint32_t id,
                                                                   std::size_t element_bytes) const;

    std::shared_ptr<const void> storage_;
    std::string name_;
    std::uint32_t version_ = 0;
    std::vector<Entry> entries_;
};

} // namespace proxima
