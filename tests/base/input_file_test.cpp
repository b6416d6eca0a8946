#include "base/input_file.h"

#include "base/without_standard_input.h"
#include "code_of.h"
#include "folder_test.h"

#include <cerrno>
#include <cstdint>
#include <fcntl.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

/// What the next calls of read() do in place of reading.
struct FailingReads {
    int calls = 0; ///< that many fail
    int error_number = 0;
    ssize_t returns = -1;
};
FailingReads failing_reads;

} // namespace

/// In place of the C library's.
extern "C" ssize_t read(int descriptor, void* buffer, std::size_t size)
{
    if (failing_reads.calls <= 0) return ::syscall(SYS_read, descriptor, buffer, size);
    --failing_reads.calls;
    errno = failing_reads.error_number;
    return failing_reads.returns;
}

namespace proxima::input_file_test {
namespace {

class InputFile : public FolderTest {
protected:
    std::string file_of(const std::string& content)
    {
        std::ofstream(path("file"), std::ios::binary) << content;
        return path("file").string();
    }

    static std::string long_content()
    {
        std::string content((std::size_t{5} << 23U) + 12345, ' '); // 40 MB: three blocks
        std::uint32_t state = 1;
        for (char& byte : content)
            byte = static_cast<char>((state = state * 1664525 + 1013904223) >> 24U);
        return content;
    }
};

TEST_F(InputFile, HasTheBytesOfFilesOfOneBlockAndMore)
{
    for (const std::string& content : {std::string("a"), std::string(1000, 'b'), long_content()}) {
        const std::string name = file_of(content);
        for (const FileAccess access : {FileAccess::read, FileAccess::map}) {
            errno = EINTR; // of an earlier call: nothing to repeat here
            const auto file = read_file(name, {.access = access});
            ASSERT_TRUE(file) << file.error().message;
            EXPECT_TRUE(file->text() == content) << content.size();
            EXPECT_EQ(reinterpret_cast<std::uintptr_t>(file->bytes.data()) % 128, 0U);
        }
    }
}

TEST_F(InputFile, IsClosedWithoutAStandardInputToo)
{
    const std::string name = file_of("a");
    for (const FileAccess access : {FileAccess::read, FileAccess::map}) {
        const WithoutStandardInput without;
        const auto file = read_file(name, {.access = access});
        ASSERT_TRUE(file) << file.error().message;
        EXPECT_EQ(file->text(), "a");
        EXPECT_EQ(::fcntl(STDIN_FILENO, F_GETFD), -1) << "the file is still open";
    }
}

TEST_F(InputFile, ReportsProgressAndStopsOnRequest)
{
    const std::string content = long_content();
    const std::string name = file_of(content);
    Progress progress;
    ASSERT_TRUE(read_file(name, {.progress = &progress}));
    EXPECT_STREQ(progress.stage(), "loading file");
    EXPECT_GT(progress.fraction(), 0.7);
    progress.cancel();
    EXPECT_EQ(code_of(read_file(name, {.progress = &progress})), ErrorCode::cancelled);
}

TEST_F(InputFile, IsWithinTheBudgetToTheByte)
{
    const std::string name = file_of(std::string(5000, 'x'));
    EXPECT_TRUE(read_file(name, {.budget = {5000}}));
    const auto refused = read_file(name, {.budget = {4999}, .advice = "take a smaller one"});
    ASSERT_FALSE(refused);
    EXPECT_EQ(code_of(refused), ErrorCode::budget_exceeded);
    EXPECT_NE(refused.error().message.find("take a smaller one"), std::string::npos);
    EXPECT_TRUE(read_file(name, {.access = FileAccess::map, .budget = {1}}));
}

TEST_F(InputFile, ClosesWhatItOpens)
{
    const std::string name = file_of("content");
    const int next = ::open("/dev/null", O_RDONLY);
    ASSERT_GE(next, 0);
    ::close(next);
    for (const FileAccess access : {FileAccess::read, FileAccess::map})
        ASSERT_TRUE(read_file(name, {.access = access}));
    ASSERT_FALSE(read_file(path("").string(), {}));
    const int now = ::open("/dev/null", O_RDONLY);
    EXPECT_EQ(now, next);
    ::close(now);
}

TEST_F(InputFile, GoesOnAfterASignalAndSaysWhatElseFails)
{
    const std::string name = file_of("content");
    failing_reads = {.calls = 1, .error_number = EIO};
    const auto broken = read_file(name, {});
    ASSERT_FALSE(broken);
    EXPECT_EQ(code_of(broken), ErrorCode::file_not_found);
    EXPECT_NE(broken.error().message.find("Input/output error"), std::string::npos)
        << broken.error().message;
    failing_reads = {.calls = 3, .error_number = EINTR};
    const auto interrupted = read_file(name, {});
    ASSERT_TRUE(interrupted) << interrupted.error().message;
    EXPECT_EQ(interrupted->text(), "content");
    EXPECT_EQ(failing_reads.calls, 0);
    // The end of the file, before its size: somebody shortened it. EINTR is of an earlier call.
    failing_reads = {.calls = 1, .error_number = EINTR, .returns = 0};
    const auto shorter = read_file(name, {});
    ASSERT_FALSE(shorter);
    EXPECT_EQ(code_of(shorter), ErrorCode::malformed_file);
    EXPECT_NE(shorter.error().message.find("from 7 to 0 bytes"), std::string::npos)
        << shorter.error().message;
}

TEST_F(InputFile, FollowsNoLinkWhereNoneIsExpected)
{
    namespace fs = std::filesystem;
    fs::create_directories(path("folder/inner"));
    const fs::path folder = fs::canonical(path("folder"));
    std::ofstream(folder / "inner" / "a") << "content";
    fs::create_symlink(folder / "inner" / "a", folder / "inner" / "link");
    fs::create_symlink("inner", folder / "other");
    const FileReadOptions options = {.follow_links = false};
    const auto plain = read_file(folder / "inner" / "a", options);
    ASSERT_TRUE(plain) << describe(plain.error());
    EXPECT_EQ(plain->text(), "content");
    for (const char* const name : {"inner/link", "other/a", "other/link"}) {
        EXPECT_TRUE(read_file(folder / name, {})) << name;
        const auto refused = read_file(folder / name, options);
        ASSERT_FALSE(refused) << name;
        EXPECT_EQ(code_of(refused), ErrorCode::file_not_found);
    }
    EXPECT_EQ(code_of(read_file(folder / "none", options)), ErrorCode::file_not_found);
    EXPECT_EQ(code_of(read_file(folder / "inner", options)), ErrorCode::file_not_found);
}

TEST_F(InputFile, SaysWhyItCannotBeRead)
{
    const auto refused = [](const std::filesystem::path& name, ErrorCode code, const char* words) {
        for (const FileAccess access : {FileAccess::read, FileAccess::map}) {
            const auto file = read_file(name, {.access = access});
            ASSERT_FALSE(file);
            EXPECT_EQ(code_of(file), code);
            EXPECT_EQ(file.error().where, name.string());
            EXPECT_NE(file.error().message.find(words), std::string::npos) << file.error().message;
        }
    };
    refused(path("none"), ErrorCode::file_not_found, "No such file");
    refused(path(""), ErrorCode::file_not_found, "folder");
    refused(file_of(""), ErrorCode::malformed_file, "empty");
    ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
    refused(path("pipe"), ErrorCode::file_not_found, "not a regular file");
    refused("/dev/null", ErrorCode::file_not_found, "not a regular file");
    if (::access("/proc/self/mem", R_OK) == 0) // a regular file of no size
        refused("/proc/self/mem", ErrorCode::malformed_file, "empty");
}

} // namespace
} // namespace proxima::input_file_test
