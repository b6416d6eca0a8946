#include "base/binary_file.h"

#include "base/check.h"
#include "base/input_file.h"
#include "base/progress.h"
#include "base/text.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
// The state of a running checksum lies on the stack.
#define XXH_STATIC_LINKING_ONLY
#include <xxhash.h>

namespace proxima {

namespace {

constexpr std::uint32_t byte_order_mark = 0x01020304;
constexpr std::uint32_t swapped_byte_order_mark = 0x04030201;
constexpr std::uint32_t max_sections = 256;

} // namespace

/// What stands before the sections.
namespace binary_file {

struct Header {
    std::array<char, 8> magic{};
    std::uint32_t byte_order = byte_order_mark;
    std::uint32_t version = 0;
    std::uint32_t sections = 0;
    std::uint32_t reserved = 0;
    std::uint64_t file_bytes = 0;
    std::uint64_t checksum = 0; ///< of header and table, this field zero
};
static_assert(sizeof(Header) == 40);

struct TableEntry {
    std::uint32_t id = 0;
    std::uint32_t element_bytes = 0;
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
    std::uint64_t checksum = 0;
};
static_assert(sizeof(TableEntry) == 32);

/// Where the sections of a file lie; checksums come later.
struct Head {
    Header header;
    std::vector<TableEntry> table;
};

} // namespace binary_file

namespace {

using binary_file::Head;
using binary_file::Header;
using binary_file::TableEntry;

std::uint64_t aligned(std::uint64_t offset) noexcept
{
    return (offset + section_alignment - 1) / section_alignment * section_alignment;
}

/// Of a section. Once `progress` is cancelled, any number.
std::uint64_t checksum(std::span<const std::byte> bytes, Progress* progress) noexcept
{
    constexpr std::size_t block = std::size_t{1} << 22U;
    if (bytes.size() <= block) {
        advance_stage(progress, bytes.size());
        return XXH3_64bits(bytes.data(), bytes.size());
    }
    XXH3_state_t state;
    XXH3_64bits_reset(&state);
    while (!bytes.empty() && !is_cancelled(progress)) {
        const auto part = bytes.first(std::min(block, bytes.size()));
        XXH3_64bits_update(&state, part.data(), part.size());
        bytes = bytes.subspan(part.size());
        advance_stage(progress, part.size());
    }
    return XXH3_64bits_digest(&state);
}

void begin_checksums(Progress* progress, std::uint64_t bytes) noexcept
{
    begin_stage(progress, "checksums", bytes);
}

/// Of header and table as they lie in the file, but with zeros for the checksum itself.
std::uint64_t head_checksum(Header header, std::span<const std::byte> table) noexcept
{
    header.checksum = 0;
    XXH3_state_t state;
    XXH3_64bits_reset(&state);
    XXH3_64bits_update(&state, &header, sizeof header);
    XXH3_64bits_update(&state, table.data(), table.size());
    return XXH3_64bits_digest(&state);
}

bool all_zero(std::span<const std::byte> bytes) noexcept
{
    for (const std::byte byte : bytes) {
        if (byte != std::byte{0}) return false;
    }
    return true;
}

/// Sets the header's checksum; the bytes that the file begins with.
std::vector<std::byte> sealed_bytes(Head& head)
{
    const auto entries = std::as_bytes(std::span(head.table));
    head.header.checksum = head_checksum(head.header, entries);
    const auto start = std::as_bytes(std::span(&head.header, 1));
    std::vector<std::byte> bytes(start.begin(), start.end());
    bytes.insert(bytes.end(), entries.begin(), entries.end());
    return bytes;
}

Result<Head> head_of(const std::filesystem::path& path, const FileFormat& format,
                     std::span<const SectionSize> sections)
{
    if (sections.size() > max_sections) {
        return fail(ErrorCode::limit_exceeded, "too many sections", path.string());
    }
    Head head;
    head.header.magic = format.magic;
    head.header.version = format.version;
    head.header.sections = static_cast<std::uint32_t>(sections.size());
    std::uint64_t end = sizeof(Header) + sections.size() * sizeof(TableEntry);
    for (const SectionSize& section : sections) {
        const std::uint64_t offset = aligned(end);
        head.table.push_back({section.id, section.element_bytes, offset, section.bytes, 0});
        end = offset + section.bytes;
    }
    head.header.file_bytes = end;
    return head;
}

/// Zeros up to where a section begins.
Status write_gap(OutputFile& file, std::uint64_t& written, std::uint64_t offset)
{
    constexpr std::array<std::byte, section_alignment> zeros{};
    const auto gap = static_cast<std::size_t>(offset - written);
    written = offset;
    return file.write(std::span(zeros).first(gap));
}

} // namespace

Status write_binary_file(const std::filesystem::path& path, const FileFormat& format,
                         std::span<const BinarySection> sections, Progress* progress)
{
    std::vector<SectionSize> sizes;
    std::uint64_t content = 0;
    for (const BinarySection& section : sections) {
        sizes.push_back({section.id, section.element_bytes, section.bytes.size()});
        content += section.bytes.size();
    }
    auto head = head_of(path, format, sizes);
    if (!head) return tl::unexpected<Error>(head.error());
    begin_checksums(progress, content);
    for (std::size_t i = 0; i < sections.size(); ++i) {
        head->table[i].checksum = checksum(sections[i].bytes, progress);
    }
    auto file = OutputFile::create(path, {progress, head->header.file_bytes});
    if (!file) return tl::unexpected<Error>(file.error());
    const std::vector<std::byte> start = sealed_bytes(*head);
    if (auto status = file->write(start); !status) return status;
    std::uint64_t written = start.size();
    for (std::size_t i = 0; i < sections.size(); ++i) {
        if (auto status = write_gap(*file, written, head->table[i].offset); !status) return status;
        if (auto status = file->write(sections[i].bytes); !status) return status;
        written += sections[i].bytes.size();
    }
    return file->commit();
}

struct BinaryFileWriter::State {
    OutputFile file;
    binary_file::Head head;
    std::uint64_t written = 0; ///< bytes of the file
    std::size_t section = 0;   ///< to which the next byte belongs
    std::uint64_t left = 0;    ///< bytes of that section to come
    XXH3_state_t checksum{};   ///< of that section so far

    /// Goes to the first section from `section` on that has bytes.
    Status begin_section()
    {
        for (; section < head.table.size(); ++section) {
            binary_file::TableEntry& entry = head.table[section];
            Status status = write_gap(file, written, entry.offset);
            if (!status) return status;
            XXH3_64bits_reset(&checksum);
            left = entry.bytes;
            if (left != 0) return {};
            entry.checksum = XXH3_64bits_digest(&checksum);
        }
        return {};
    }
};

BinaryFileWriter::BinaryFileWriter(std::unique_ptr<State> state) noexcept : state_(std::move(state))
{}
BinaryFileWriter::BinaryFileWriter(BinaryFileWriter&&) noexcept = default;
BinaryFileWriter& BinaryFileWriter::operator=(BinaryFileWriter&&) noexcept = default;
BinaryFileWriter::~BinaryFileWriter() = default;

Result<BinaryFileWriter> BinaryFileWriter::create(const std::filesystem::path& path,
                                                  const FileFormat& format,
                                                  std::span<const SectionSize> sections,
                                                  Progress* progress)
{
    auto head = head_of(path, format, sections);
    if (!head) return tl::unexpected<Error>(head.error());
    auto file = OutputFile::create(path, {progress, head->header.file_bytes});
    if (!file) return tl::unexpected<Error>(file.error());
    // No file until its head is there.
    const std::vector<std::byte> zeros(sizeof(Header) + sections.size() * sizeof(TableEntry));
    if (auto status = file->write(zeros); !status) return tl::unexpected<Error>(status.error());
    auto state = std::make_unique<State>(State{std::move(*file), std::move(*head)});
    state->written = zeros.size();
    if (auto status = state->begin_section(); !status) return tl::unexpected<Error>(status.error());
    return BinaryFileWriter(std::move(state));
}

Status BinaryFileWriter::write(std::span<const std::byte> bytes)
{
    State& state = *state_;
    while (!bytes.empty()) {
        PROXIMA_CHECK(state.section < state.head.table.size());
        const auto part = bytes.first(
            static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), state.left)));
        bytes = bytes.subspan(part.size());
        if (auto status = state.file.write(part); !status) return status;
        XXH3_64bits_update(&state.checksum, part.data(), part.size());
        state.written += part.size();
        state.left -= part.size();
        if (state.left != 0) break;
        state.head.table[state.section++].checksum = XXH3_64bits_digest(&state.checksum);
        if (auto status = state.begin_section(); !status) return status;
    }
    return {};
}

Status BinaryFileWriter::commit()
{
    State& state = *state_;
    if (auto status = state.file.write(std::string_view()); !status) return status;
    PROXIMA_CHECK(state.section == state.head.table.size());
    if (auto status = state.file.overwrite(0, sealed_bytes(state.head)); !status) return status;
    return state.file.commit();
}

void reseal_binary_file(std::span<std::byte> bytes) noexcept
{
    Header header;
    if (bytes.size() < sizeof header) return;
    std::memcpy(&header, bytes.data(), sizeof header);
    const std::uint64_t table_bytes = std::uint64_t{header.sections} * sizeof(TableEntry);
    if (table_bytes > bytes.size() - sizeof header) return;
    const auto table = bytes.subspan(sizeof header, table_bytes);
    for (std::size_t at = 0; at < table.size(); at += sizeof(TableEntry)) {
        TableEntry entry;
        std::memcpy(&entry, &table[at], sizeof entry);
        if (entry.offset > bytes.size() || entry.bytes > bytes.size() - entry.offset) continue;
        entry.checksum = checksum(bytes.subspan(entry.offset, entry.bytes), nullptr);
        std::memcpy(&table[at], &entry, sizeof entry);
    }
    header.checksum = head_checksum(header, table);
    std::memcpy(bytes.data(), &header, sizeof header);
}

Result<BinaryFile> BinaryFile::open(const std::filesystem::path& path, const FileFormat& format,
                                    const BinaryFileOptions& options)
{
    auto file = read_file(path, {.access = options.access,
                                 .budget = options.budget,
                                 .progress = options.progress,
                                 .advice = "raise the budget or map the file"});
    if (!file) return tl::unexpected<Error>(file.error());
    return read(file->bytes, std::move(file->storage), path.string(), format, options.verify,
                options.progress);
}

Result<BinaryFile> BinaryFile::read(std::span<const std::byte> bytes,
                                    std::shared_ptr<const void> storage, const std::string& name,
                                    const FileFormat& format, Verification verification,
                                    Progress* progress)
{
    const auto refuse = [&](ErrorCode code, std::string message) {
        return fail(code, std::move(message), name);
    };
    if (reinterpret_cast<std::uintptr_t>(bytes.data()) % section_alignment != 0) {
        return refuse(ErrorCode::invalid_argument,
                      concat("the bytes must begin at a multiple of ", section_alignment,
                             ": copy them to such a place"));
    }
    Header header;
    if (bytes.size() < sizeof header.magic ||
        std::memcmp(bytes.data(), format.magic.data(), sizeof header.magic) != 0) {
        return refuse(ErrorCode::unsupported_format, concat("this is no ", format.name));
    }
    if (bytes.size() < sizeof header) {
        return refuse(ErrorCode::malformed_file, "the file ends within its header");
    }
    std::memcpy(&header, bytes.data(), sizeof header);
    if (header.byte_order == swapped_byte_order_mark) {
        return refuse(ErrorCode::unsupported_format,
                      "written by a machine of the other byte order: convert it there");
    }
    if (header.byte_order != byte_order_mark) {
        return refuse(ErrorCode::malformed_file, "the byte order mark is damaged");
    }
    if (header.version > format.version || header.version == 0) {
        return refuse(ErrorCode::unsupported_format,
                      concat("version ", header.version,
                             " of the format, this program reads up to ", format.version));
    }
    if (header.file_bytes != bytes.size()) {
        return refuse(ErrorCode::malformed_file,
                      concat("the file should have ", header.file_bytes, " bytes and has ",
                             bytes.size(), ": it is damaged or cut off"));
    }
    if (header.sections > max_sections ||
        sizeof header + header.sections * sizeof(TableEntry) > bytes.size()) {
        return refuse(ErrorCode::malformed_file, "the table of sections is damaged");
    }
    std::vector<TableEntry> table(header.sections);
    if (!table.empty()) {
        std::memcpy(table.data(), bytes.data() + sizeof header, table.size() * sizeof(TableEntry));
    }
    if (head_checksum(header, std::as_bytes(std::span(table))) != header.checksum ||
        header.reserved != 0) {
        return refuse(ErrorCode::malformed_file, "the checksum of the header is wrong: damaged");
    }

    BinaryFile file;
    file.storage_ = std::move(storage);
    file.name_ = name;
    file.version_ = header.version;
    begin_checksums(progress, verification == Verification::full ? bytes.size() : 0);
    std::uint64_t end = sizeof header + table.size() * sizeof(TableEntry);
    for (const TableEntry& entry : table) {
        if (entry.offset != aligned(end) || entry.offset > bytes.size() ||
            entry.bytes > bytes.size() - entry.offset || entry.element_bytes == 0 ||
            entry.bytes % entry.element_bytes != 0) {
            return refuse(ErrorCode::malformed_file,
                          concat("section ", entry.id, " has an impossible position or size"));
        }
        const auto content = bytes.subspan(entry.offset, entry.bytes);
        if (!all_zero(bytes.subspan(end, entry.offset - end))) {
            return refuse(ErrorCode::malformed_file, "bytes between sections are damaged");
        }
        const bool is_damaged =
            verification == Verification::full && checksum(content, progress) != entry.checksum;
        if (is_cancelled(progress)) {
            return cancelled("reading", name);
        }
        if (is_damaged) {
            return refuse(ErrorCode::malformed_file,
                          concat("the checksum of section ", entry.id, " is wrong: damaged"));
        }
        file.entries_.push_back({entry.id, entry.element_bytes, content});
        end = entry.offset + entry.bytes;
    }
    if (end != bytes.size()) {
        return refuse(ErrorCode::malformed_file, "bytes behind the last section");
    }
    return file;
}

Result<std::span<const std::byte>> BinaryFile::section_bytes(std::uint32_t id,
                                                             std::size_t element_bytes) const
{
    for (const Entry& entry : entries_) {
        if (entry.id != id) continue;
        if (entry.element_bytes != element_bytes) {
            return fail(ErrorCode::malformed_file,
                        concat("section ", id, " has elements of ", entry.element_bytes,
                               " bytes instead of ", element_bytes),
                        name_);
        }
        return entry.bytes;
    }
    return fail(ErrorCode::malformed_file, concat("section ", id, " is missing"), name_);
}

} // namespace proxima
