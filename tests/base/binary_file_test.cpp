#include "base/binary_file.h"

#include "code_of.h"
#include "damaged_files.h"
#include "folder_test.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

namespace proxima::binary_file_test {
namespace {

using namespace testing;

constexpr FileFormat format = {{'t', 'e', 's', 't', 'f', 'i', 'l', 'e'}, 3, "test file"};
constexpr std::size_t header_bytes = 40;
constexpr std::size_t entry_bytes = 32;

class BinaryFileTest : public FolderTest {
protected:
    std::string save(std::span<const BinarySection> sections)
    {
        const Status saved = write_binary_file(path("file"), format, sections);
        EXPECT_TRUE(saved) << saved.error().message;
        std::ifstream file(path("file"), std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    std::string save()
    {
        const std::array sections = {binary_section<std::uint32_t>(7, words),
                                     binary_section<std::uint8_t>(2, {}),
                                     binary_section<double>(9, numbers)};
        return save(sections);
    }

    static Result<BinaryFile> load(const std::string& content, Verification verification)
    {
        // Aligned as a file is.
        const auto memory =
            std::make_shared<std::vector<std::array<std::byte, 128>>>(content.size() / 128 + 2);
        void* first = memory->data();
        std::size_t room = memory->size() * 128;
        std::align(128, content.size(), first, room);
        std::memcpy(first, content.data(), content.size());
        return BinaryFile::read({static_cast<const std::byte*>(first), content.size()}, memory,
                                "in memory", format, verification);
    }

    static void expect_refused(const std::string& content, ErrorCode code, const char* words)
    {
        const auto file = load(content, Verification::structure);
        ASSERT_FALSE(file) << words;
        EXPECT_EQ(code_of(file), code);
        EXPECT_EQ(file.error().where, "in memory");
        EXPECT_NE(file.error().message.find(words), std::string::npos) << file.error().message;
    }

    /// With a number of 4 or 8 bytes written over, and right checksums.
    template <class Number>
    static std::string with(std::string content, std::size_t at, Number number)
    {
        std::memcpy(&content[at], &number, sizeof number);
        reseal_binary_file(std::as_writable_bytes(std::span(content)));
        return content;
    }

    const std::vector<std::uint32_t> words = {1, 2, 3, 4, 5};
    const std::vector<double> numbers = std::vector<double>(20, 0.5);
};

TEST_F(BinaryFileTest, WriterInPiecesWritesTheSameBytes)
{
    const std::string expected = save();
    const std::array sizes = {SectionSize{7, 4, 4 * words.size()}, SectionSize{2, 1, 0},
                              SectionSize{9, 8, 8 * numbers.size()}};
    std::vector<std::byte> bytes;
    for (const auto part : {std::as_bytes(std::span(words)), std::as_bytes(std::span(numbers))}) {
        bytes.insert(bytes.end(), part.begin(), part.end());
    }
    for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, bytes.size()}) {
        auto writer = BinaryFileWriter::create(path("pieces"), format, sizes);
        ASSERT_TRUE(writer) << describe(writer.error());
        for (std::size_t first = 0; first < bytes.size(); first += piece) {
            const std::size_t end = std::min(bytes.size(), first + piece);
            ASSERT_TRUE(writer->write(std::span(bytes).subspan(first, end - first)));
            EXPECT_FALSE(std::filesystem::exists(path("pieces")));
        }
        ASSERT_TRUE(writer->commit());
        std::ifstream file(path("pieces"), std::ios::binary);
        EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), expected);
        std::filesystem::remove(path("pieces"));
    }
}

TEST_F(BinaryFileTest, HoldsWhatWasWritten)
{
    (void)save();
    for (const FileAccess access : {FileAccess::read, FileAccess::map}) {
        for (const Verification verify : {Verification::full, Verification::structure}) {
            const auto file =
                BinaryFile::open(path("file"), format, {.verify = verify, .access = access});
            ASSERT_TRUE(file) << file.error().message;
            EXPECT_EQ(file->version(), 3U);
            const auto first = file->section<std::uint32_t>(7).value();
            EXPECT_EQ(std::vector(first.begin(), first.end()), words);
            EXPECT_EQ(reinterpret_cast<std::uintptr_t>(first.data()) % section_alignment, 0U);
            const auto second = file->section<double>(9).value();
            EXPECT_EQ(std::vector(second.begin(), second.end()), numbers);
            EXPECT_EQ(reinterpret_cast<std::uintptr_t>(second.data()) % section_alignment, 0U);
            EXPECT_TRUE(file->section<std::uint8_t>(2).value().empty());
            EXPECT_EQ(code_of(file->section<std::uint32_t>(9)), ErrorCode::malformed_file);
            EXPECT_EQ(code_of(file->section<std::uint32_t>(8)), ErrorCode::malformed_file);
        }
    }
}

TEST_F(BinaryFileTest, RefusesEveryDamage)
{
    const std::string content = save();
    refuses_every_truncation_and_extension(content, load);
    refuses_every_flipped_bit(content, load);
    // The table's checksum alone tells of a section's checksum that was changed.
    for (std::size_t i = 0; i < header_bytes + 3 * entry_bytes; ++i) {
        std::string damaged = content;
        damaged[i] = static_cast<char>(damaged[i] ^ 1);
        EXPECT_FALSE(load(damaged, Verification::structure)) << "byte " << i;
    }
    // What it does not look at.
    std::string damaged = content;
    damaged.back() = 1;
    EXPECT_TRUE(load(damaged, Verification::structure));
}

TEST_F(BinaryFileTest, RefusesCraftedHeadersAndTables)
{
    const std::string content = save();
    const std::size_t table = header_bytes;
    const auto malformed = ErrorCode::malformed_file;
    const auto foreign = ErrorCode::unsupported_format;
    std::string other = content;
    other[7] = 'X';
    expect_refused(other, foreign, "this is no test file");
    expect_refused("", foreign, "this is no test file");
    expect_refused(content.substr(0, header_bytes - 1), malformed, "within its header");
    expect_refused(with(content, 8, 0x04030201U), foreign, "other byte order");
    expect_refused(with(content, 8, 0x01020305U), malformed, "byte order mark");
    expect_refused(with(content, 12, 4U), foreign, "version 4");
    expect_refused(with(content, 12, 0U), foreign, "version 0");
    EXPECT_TRUE(load(with(content, 12, 2U), Verification::full));
    expect_refused(with(content, 16, 4U), malformed, "section 0 has an impossible position");
    expect_refused(with(content, 16, 0x10000000U), malformed, "table of sections");
    expect_refused(with(content, 20, 1U), malformed, "header");
    expect_refused(with(content, 24, content.size() + 1), malformed, "should have");
    expect_refused(with(content, table + 4, 0U), malformed, "section 7");
    expect_refused(with(content, table + 4, 3U), malformed, "section 7");
    expect_refused(with(content, table + 8, std::uint64_t{384}), malformed, "section 7");
    expect_refused(with(content, table + 8, ~std::uint64_t{0} - 127), malformed, "section 7");
    expect_refused(with(content, table + 16, content.size()), malformed, "section 7");
    expect_refused(with(content, table + 16, ~std::uint64_t{3}), malformed, "section 7");
    expect_refused(with(content, table + 16, std::uint64_t{16}), malformed, "between sections");
    expect_refused(with(content, table + 2 * entry_bytes + 8, std::uint64_t{512}), malformed,
                   "section 9");
}

TEST_F(BinaryFileTest, ReportsProgressAndStopsOnRequest)
{
    Progress progress;
    const std::array sections = {binary_section<double>(9, numbers)};
    ASSERT_TRUE(write_binary_file(path("file"), format, sections, &progress));
    EXPECT_STREQ(progress.stage(), "writing");
    progress.cancel();
    EXPECT_EQ(code_of(write_binary_file(path("file"), format, sections, &progress)),
              ErrorCode::cancelled);
    EXPECT_EQ(code_of(BinaryFile::open(path("file"), format, {.progress = &progress})),
              ErrorCode::cancelled);
    EXPECT_TRUE(BinaryFile::open(path("file"), format, {}));
}

TEST_F(BinaryFileTest, HasUpTo256Sections)
{
    const std::uint8_t byte = 1;
    std::vector<BinarySection> sections;
    for (std::uint32_t id = 0; id < 256; ++id)
        sections.push_back(binary_section<std::uint8_t>(id, std::span(&byte, 1)));
    ASSERT_TRUE(write_binary_file(path("file"), format, sections));
    const auto file = BinaryFile::open(path("file"), format, {});
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->section<std::uint8_t>(255).value()[0], 1);
    sections.push_back(binary_section<std::uint8_t>(256, std::span(&byte, 1)));
    EXPECT_EQ(code_of(write_binary_file(path("file"), format, sections)),
              ErrorCode::limit_exceeded);
    EXPECT_TRUE(BinaryFile::open(path("file"), format, {})) << "the file is as it was";
}

} // namespace
} // namespace proxima::binary_file_test
