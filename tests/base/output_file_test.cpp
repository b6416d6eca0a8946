#include "base/output_file.h"

#include "base/without_standard_input.h"
#include "code_of.h"
#include "folder_test.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <grp.h>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace proxima::output_file_test {

/// What another process does to the next file that is locked, just before.
enum class Meddling { none, locks, removes };
static Meddling meddling = Meddling::none;

} // namespace proxima::output_file_test

/// In place of the C library's, for all of this program.
extern "C" int flock(int descriptor, int operation) noexcept
{
    using proxima::output_file_test::Meddling;
    switch (std::exchange(proxima::output_file_test::meddling, Meddling::none)) {
    case Meddling::none:
        break;
    case Meddling::locks:
        errno = EWOULDBLOCK;
        return -1;
    case Meddling::removes: {
        std::error_code error;
        std::filesystem::remove(
            std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor), error),
            error);
    }
    }
    return static_cast<int>(::syscall(SYS_flock, descriptor, operation));
}

namespace proxima::output_file_test {
namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

class OutputFileTest : public FolderTest {};

TEST_F(OutputFileTest, KeepsTheOldContentUntilCommitted)
{
    std::ofstream(path("a.txt")) << "old";
    {
        auto file = OutputFile::create(path("a.txt"));
        ASSERT_TRUE(file) << describe(file.error());
        ASSERT_TRUE(file->write("new"));
        EXPECT_EQ(content(path("a.txt")), "old");
        ASSERT_TRUE(file->commit());
    }
    EXPECT_EQ(content(path("a.txt")), "new");
    EXPECT_EQ(entries(), 1);
}

TEST_F(OutputFileTest, OverwritesWhatWasWritten)
{
    const std::string head = "head";
    auto file = OutputFile::create(path("a.txt"));
    ASSERT_TRUE(file) << describe(file.error());
    ASSERT_TRUE(file->write("....body"));
    ASSERT_TRUE(file->overwrite(0, std::as_bytes(std::span(head))));
    ASSERT_TRUE(file->write("foot"));
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(content(path("a.txt")), "headbodyfoot");
    auto direct = OutputFile::create("/dev/null");
    ASSERT_TRUE(direct);
    EXPECT_FALSE(direct->overwrite(0, std::as_bytes(std::span(head))));
}

TEST_F(OutputFileTest, ReplacesFilesInSharedMemory)
{
    std::string folder = "/dev/shm/proxima-XXXXXX";
    if (::mkdtemp(folder.data()) == nullptr) GTEST_SKIP() << "no /dev/shm here";
    const fs::path place = fs::path(folder) / "a.txt";
    for (const char* text : {"longer", "new"}) {
        auto file = OutputFile::create(place);
        EXPECT_TRUE(file && file->write(text) && file->commit());
        EXPECT_EQ(content(place), text);
    }
    fs::remove_all(folder);
}

TEST_F(OutputFileTest, IsWrittenWithoutAStandardInputToo)
{
    for (const fs::path& destination : {path("a.txt"), fs::path("/dev/null")}) {
        const WithoutStandardInput without;
        auto file = OutputFile::create(destination);
        ASSERT_TRUE(file) << describe(file.error());
        EXPECT_NE(::fcntl(STDIN_FILENO, F_GETFD), -1) << "another descriptor than 0";
        ASSERT_TRUE(file->write("new"));
        ASSERT_TRUE(file->commit());
        EXPECT_EQ(::fcntl(STDIN_FILENO, F_GETFD), -1) << "the file is still open";
    }
    EXPECT_EQ(content(path("a.txt")), "new");
    EXPECT_EQ(entries(), 1);
}

TEST_F(OutputFileTest, KeepsTheOldContentWhenCancelled)
{
    std::ofstream(path("a.txt")) << "old";
    Progress progress;
    auto file = OutputFile::create(path("a.txt"), {&progress, 3'000'000});
    ASSERT_TRUE(file) << describe(file.error());
    ASSERT_TRUE(file->write(std::string(1'000'000, 'x')));
    EXPECT_STREQ(progress.stage(), "writing");
    EXPECT_GT(progress.fraction(), 0.2);
    progress.cancel();
    EXPECT_EQ(code_of(file->write(std::string(1'000'000, 'x'))), ErrorCode::cancelled);
    EXPECT_EQ(code_of(file->commit()), ErrorCode::cancelled);
    EXPECT_EQ(content(path("a.txt")), "old");
    EXPECT_EQ(entries(), 1);
}

TEST_F(OutputFileTest, LeavesNothingBehindWhenDiscarded)
{
    {
        auto file = OutputFile::create(path("a.txt"));
        ASSERT_TRUE(file);
        ASSERT_TRUE(file->write(std::string(1'000'000, 'x')));
        EXPECT_EQ(entries(), 1);
    }
    EXPECT_EQ(entries(), 0);
}

TEST_F(OutputFileTest, WritesMoreThanItsBufferInPiecesOfAnySize)
{
    auto file = OutputFile::create(path("a.txt"));
    ASSERT_TRUE(file);
    std::string expected;
    for (std::size_t size = 0; size < 3000; ++size) {
        const std::string piece(size, static_cast<char>('a' + size % 26));
        expected += piece;
        ASSERT_TRUE(file->write(std::as_bytes(std::span(piece))));
    }
    const std::string large(1'000'000, '-');
    expected += large;
    ASSERT_TRUE(file->write(large));
    ASSERT_TRUE(file->commit());
    EXPECT_TRUE(content(path("a.txt")) == expected);
}

TEST_F(OutputFileTest, KeepsPermissionsAndLinks)
{
    std::ofstream(path("a.txt")) << "old";
    fs::permissions(path("a.txt"), fs::perms::owner_read | fs::perms::owner_write);
    fs::create_symlink("a.txt", path("link.txt"));
    auto file = OutputFile::create(path("link.txt"));
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write("new"));
    ASSERT_TRUE(file->commit());
    EXPECT_TRUE(fs::is_symlink(path("link.txt")));
    EXPECT_EQ(content(path("a.txt")), "new");
    EXPECT_EQ(fs::status(path("a.txt")).permissions(),
              fs::perms::owner_read | fs::perms::owner_write);
}

mode_t mode_of(const fs::path& path)
{
    struct stat status {};
    EXPECT_EQ(::stat(path.c_str(), &status), 0);
    return status.st_mode & 07777U;
}

void replace(const fs::path& path)
{
    auto file = OutputFile::create(path);
    ASSERT_TRUE(file) << describe(file.error());
    ASSERT_TRUE(file->write("new"));
    ASSERT_TRUE(file->commit());
}

TEST_F(OutputFileTest, DropsBitsThatChangeTheUserOrGroup)
{
    for (const mode_t mode : {04755U, 02775U, 01644U, 0600U, 0777U, 06750U}) {
        std::ofstream(path("a.txt")) << "old";
        ASSERT_EQ(::chmod(path("a.txt").c_str(), mode), 0);
        replace(path("a.txt"));
        EXPECT_EQ(mode_of(path("a.txt")), mode & 0777U);
    }
}

TEST_F(OutputFileTest, DoesNotTakeOverTheModeOfAnotherUsersFile)
{
    if (::geteuid() != 0) GTEST_SKIP() << "needs the superuser's rights to give a file away";
    std::ofstream(path("a.txt")) << "old";
    ASSERT_EQ(::chown(path("a.txt").c_str(), 65534, 65534), 0);
    ASSERT_EQ(::chmod(path("a.txt").c_str(), 0777), 0);
    const mode_t mask = ::umask(027);
    replace(path("a.txt"));
    ::umask(mask);
    struct stat status {};
    ASSERT_EQ(::stat(path("a.txt").c_str(), &status), 0);
    EXPECT_EQ(status.st_uid, ::geteuid());
    EXPECT_EQ(status.st_gid, ::getegid());
    EXPECT_EQ(mode_of(path("a.txt")), 0640U);
}

TEST_F(OutputFileTest, KeepsTheGroup)
{
    if (::geteuid() != 0) GTEST_SKIP() << "needs the superuser's rights to choose any group";
    std::ofstream(path("a.txt")) << "old";
    ASSERT_EQ(::chown(path("a.txt").c_str(), ::geteuid(), 65534), 0);
    ASSERT_EQ(::chmod(path("a.txt").c_str(), 0660), 0);
    replace(path("a.txt"));
    struct stat status {};
    ASSERT_EQ(::stat(path("a.txt").c_str(), &status), 0);
    EXPECT_EQ(status.st_gid, 65534U);
    EXPECT_EQ(mode_of(path("a.txt")), 0660U);
}

// In a child that is not a member of the file's group: the group that the new file has instead
// gets no right that it did not have.
TEST_F(OutputFileTest, GivesAnotherGroupTheRightsOfAllWhereTheGroupCannotBeKept)
{
    if (::geteuid() != 0) GTEST_SKIP() << "needs the superuser's rights to become another user";
    std::ofstream(path("a.txt")) << "old";
    ASSERT_EQ(::chown(path("a.txt").c_str(), 65534, 7), 0);
    ASSERT_EQ(::chmod(path("a.txt").c_str(), 0664), 0);
    fs::permissions(path("."), fs::perms::all);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        if (::setgroups(0, nullptr) != 0 || ::setgid(65534) != 0 || ::setuid(65534) != 0)
            ::_exit(1);
        auto file = OutputFile::create(path("a.txt"));
        ::_exit(file && file->write("new") && file->commit() ? 0 : 2);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
    EXPECT_EQ(content(path("a.txt")), "new");
    EXPECT_EQ(mode_of(path("a.txt")), 0644U);
}

TEST_F(OutputFileTest, LeavesOtherHardLinksWhatTheyHad)
{
    std::ofstream(path("a.txt")) << "old";
    fs::create_hard_link(path("a.txt"), path("b.txt"));
    replace(path("a.txt"));
    EXPECT_EQ(content(path("a.txt")), "new");
    EXPECT_EQ(content(path("b.txt")), "old");
}

TEST_F(OutputFileTest, RemovesWhatAKilledProcessLeft)
{
    const pid_t killed = ::fork();
    ASSERT_GE(killed, 0);
    if (killed == 0) {
        auto file = OutputFile::create(path("a.txt"));
        if (!file || !file->write(std::string(1'000'000, 'x'))) ::_exit(1);
        ::raise(SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(killed, &status, 0), killed);
    ASSERT_TRUE(WIFSIGNALED(status));
    ASSERT_EQ(entries(), 1);

    std::ofstream(path("kept.txt")) << "kept";
    fs::create_symlink("kept.txt", path(".proxima-1-1.tmp"));
    const char* const others[] = {".proxima-1-x.tmp", ".proxima-24-12-01.tmp", ".proxima-07-1.tmp",
                                  ".proxima-7-.tmp",  ".proxima-71.tmp",       ".proxima-.tmp"};
    for (const char* const name : others)
        std::ofstream(path(name)) << "no name of a temporary file";
    fs::create_directory(path(".proxima-1-2.tmp"));
    std::ofstream(path(".proxima-1-3.tmp")) << "being written";
    const int writer = ::open(path(".proxima-1-3.tmp").c_str(), O_WRONLY);
    ASSERT_EQ(::flock(writer, LOCK_EX), 0);
    replace(path("b.txt"));
    ::close(writer);
    EXPECT_EQ(content(path("b.txt")), "new");
    EXPECT_EQ(content(path("kept.txt")), "kept");
    for (const char* const name : {".proxima-1-1.tmp", ".proxima-1-2.tmp", ".proxima-1-3.tmp"})
        EXPECT_TRUE(fs::exists(fs::symlink_status(path(name)))) << name;
    for (const char* const name : others) EXPECT_TRUE(fs::exists(path(name))) << name;
    EXPECT_EQ(entries(), 11);
}

// In a child without the superuser's rights: what replaces a file that may only be written may not be read
// either.
TEST_F(OutputFileTest, RemovesLeftFilesThatMayNotBeRead)
{
    fs::permissions(path("."), fs::perms::all);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        constexpr uid_t nobody = 65534;
        if (::geteuid() == 0 && ::setuid(nobody) != 0) ::_exit(1);
        std::ofstream(path(".proxima-1-1.tmp")) << "left";
        if (::chmod(path(".proxima-1-1.tmp").c_str(), 0200) != 0) ::_exit(2);
        replace(path("a.txt"));
        ::_exit(fs::exists(path(".proxima-1-1.tmp")) ? 3 : 0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_EQ(entries(), 1);
}

TEST_F(OutputFileTest, TakesAnotherNameWhereOneWasTakenForAbandoned)
{
    replace(path("a.txt")); // what looks through the folder locks files, too
    for (const Meddling one : {Meddling::locks, Meddling::removes}) {
        meddling = one;
        auto file = OutputFile::create(path("a.txt"));
        ASSERT_TRUE(file) << describe(file.error());
        EXPECT_EQ(meddling, Meddling::none);
        ASSERT_TRUE(file->write("written"));
        const auto status = file->commit();
        ASSERT_TRUE(status) << describe(status.error());
        EXPECT_EQ(content(path("a.txt")), "written");
        fs::remove(path("a.txt"));
    }
}

TEST_F(OutputFileTest, CreatesTheTargetOfADanglingLinkAndRefusesALoop)
{
    fs::create_symlink("later.txt", path("link.txt"));
    auto file = OutputFile::create(path("link.txt"));
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write("new"));
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(content(path("later.txt")), "new");

    fs::create_symlink("loop", path("loop"));
    const auto loop = OutputFile::create(path("loop"));
    ASSERT_FALSE(loop);
    EXPECT_EQ(code_of(loop), ErrorCode::file_not_writable);
}

TEST_F(OutputFileTest, ReportsWhyADestinationCannotBeWritten)
{
    const auto missing = OutputFile::create(path("missing/a.txt"));
    ASSERT_FALSE(missing);
    EXPECT_EQ(code_of(missing), ErrorCode::file_not_writable);
    EXPECT_NE(missing.error().message.find("does not exist"), std::string::npos);
    EXPECT_EQ(missing.error().where, path("missing/a.txt").string());

    std::ofstream(path("a.obj")).flush();
    for (const char* inside : {"a.obj/a.csv", "a.obj/b/a.csv"}) {
        const auto file_as_folder = OutputFile::create(path(inside));
        ASSERT_FALSE(file_as_folder);
        EXPECT_EQ(code_of(file_as_folder), ErrorCode::file_not_writable);
        EXPECT_NE(file_as_folder.error().message.find(path("a.obj").string() + " is not a folder"),
                  std::string::npos)
            << file_as_folder.error().message;
    }

    // A folder that is there, in which nobody can make files.
    const auto closed = OutputFile::create("/proc/a.txt");
    ASSERT_FALSE(closed);
    EXPECT_EQ(code_of(closed), ErrorCode::file_not_writable);
    EXPECT_NE(closed.error().message.find("choose a folder that you may write to"),
              std::string::npos);

    fs::create_directory(path("folder"));
    const auto folder = OutputFile::create(path("folder"));
    ASSERT_FALSE(folder);
    EXPECT_EQ(code_of(folder), ErrorCode::file_not_writable);
    EXPECT_NE(folder.error().message.find("folder"), std::string::npos);
    EXPECT_FALSE(OutputFile::create(path("folder/")));
    EXPECT_FALSE(OutputFile::create(""));
}

TEST_F(OutputFileTest, RefusesNamesThatAreTooLongBeforeAnythingIsWritten)
{
    EXPECT_TRUE(OutputFile::create(path(std::string(255, 'a'))));
    const auto file = OutputFile::create(path(std::string(256, 'a')));
    ASSERT_FALSE(file);
    EXPECT_EQ(code_of(file), ErrorCode::file_not_writable);
    EXPECT_NE(file.error().message.find("shorter"), std::string::npos);
}

// In a child that gives up the superuser's rights, which reach everywhere.
TEST_F(OutputFileTest, RefusesReadOnlyFilesAndFolders)
{
    std::ofstream(path("a.txt")) << "old";
    fs::create_directory(path("folder"));
    fs::permissions(path("a.txt"), fs::perms::owner_read | fs::perms::others_read);
    fs::permissions(path("folder"), fs::perms::owner_read | fs::perms::owner_exec);
    fs::permissions(path("."), fs::perms::all);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        constexpr uid_t nobody = 65534;
        if (::geteuid() == 0 && ::setuid(nobody) != 0) ::_exit(1);
        const auto file = OutputFile::create(path("a.txt"));
        if (file || file.error().code != ErrorCode::file_not_writable) ::_exit(2);
        const auto in_folder = OutputFile::create(path("folder/b.txt"));
        if (in_folder || in_folder.error().code != ErrorCode::file_not_writable) ::_exit(3);
        ::_exit(OutputFile::create(path("c.txt")) ? 0 : 4);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST_F(OutputFileTest, WritesToAPipeDirectly)
{
    ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
    const int reader = ::open(path("pipe").c_str(), O_RDONLY | O_NONBLOCK);
    ASSERT_GE(reader, 0);
    auto file = OutputFile::create(path("pipe"));
    ASSERT_TRUE(file) << describe(file.error());
    ASSERT_TRUE(file->write("through"));
    ASSERT_TRUE(file->commit());
    std::array<char, 16> buffer{};
    EXPECT_EQ(::read(reader, buffer.data(), buffer.size()), 7);
    EXPECT_EQ(std::string(buffer.data(), 7), "through");
    ::close(reader);
    EXPECT_TRUE(fs::is_fifo(path("pipe")));
}

TEST_F(OutputFileTest, WaitsForAPipesReaderForSomeSeconds)
{
    ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
    const auto refused = OutputFile::create(path("pipe"));
    ASSERT_FALSE(refused);
    EXPECT_EQ(code_of(refused), ErrorCode::file_not_writable);
    EXPECT_NE(refused.error().message.find("start its reader first"), std::string::npos);

    Progress progress;
    progress.cancel();
    const auto stopped = OutputFile::create(path("pipe"), {.progress = &progress});
    ASSERT_FALSE(stopped);
    EXPECT_EQ(code_of(stopped), ErrorCode::cancelled);

    std::string read;
    std::jthread reader([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        read = content(path("pipe"));
    });
    auto file = OutputFile::create(path("pipe"));
    ASSERT_TRUE(file) << describe(file.error());
    const std::string sent(1'000'000, 'x'); // more than a pipe holds
    EXPECT_TRUE(file->write(sent));
    EXPECT_TRUE(file->commit());
    reader.join();
    EXPECT_TRUE(read == sent) << read.size();
}

TEST(OutputFileDevices, ReportsAFullDeviceAtTheLatestOnCommit)
{
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    auto file = OutputFile::create("/dev/full");
    ASSERT_TRUE(file) << describe(file.error());
    (void)file->write("x");
    const auto status = file->commit();
    ASSERT_FALSE(status);
    EXPECT_EQ(code_of(status), ErrorCode::file_not_writable);
    EXPECT_EQ(status.error().message.find("kept"), std::string::npos) << status.error().message;

    auto large = OutputFile::create("/dev/full");
    ASSERT_TRUE(large);
    EXPECT_FALSE(large->write(std::string(1'000'000, 'x')));
    EXPECT_FALSE(large->write("y"));
    EXPECT_FALSE(large->commit());
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

// In a child, because the limit stays.
TEST_F(OutputFileTest, ReportsAFileSizeLimitWithoutDyingOfItsSignal)
{
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        const rlimit limit{4096, 4096};
        (void)::setrlimit(RLIMIT_FSIZE, &limit);
        auto file = OutputFile::create(path("a.txt"));
        if (!file) ::_exit(1);
        (void)file->write(std::string(1'000'000, 'x'));
        const auto status = file->commit();
        if (status || status.error().code != ErrorCode::file_not_writable) ::_exit(2);
        if (!status.error().message.ends_with("nothing of it was kept")) ::_exit(4);
        ::_exit(entries() == 0 ? 0 : 3);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
    EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST_F(OutputFileTest, LastOfTwoCommitsWins)
{
    auto first = OutputFile::create(path("a.txt"));
    auto second = OutputFile::create(path("a.txt"));
    ASSERT_TRUE(first && second);
    ASSERT_TRUE(first->write("first"));
    ASSERT_TRUE(second->write("second"));
    ASSERT_TRUE(second->commit());
    ASSERT_TRUE(first->commit());
    EXPECT_EQ(content(path("a.txt")), "first");
    EXPECT_EQ(entries(), 1);
}

TEST(OutputFileDeathTest, TakesNothingAfterItWasCommitted)
{
    auto file = OutputFile::create("/dev/null");
    ASSERT_TRUE(file && file->commit());
    EXPECT_DEATH((void)file->write("more"), "check failed: state_ != nullptr");
    EXPECT_DEATH((void)file->overwrite(0, {}), "check failed: state_ != nullptr");
    EXPECT_DEATH((void)file->commit(), "check failed: state_ != nullptr");
}

TEST_F(OutputFileTest, AppendsToStandardOutputWhenItIsAFile)
{
    std::ofstream(path("redirected.txt")) << "before ";
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        const int redirected = ::open(path("redirected.txt").c_str(), O_WRONLY | O_APPEND);
        if (::dup2(redirected, STDOUT_FILENO) < 0) ::_exit(1);
        auto file = OutputFile::create("/dev/stdout");
        if (!file || !file->write("after") || !file->commit()) ::_exit(2);
        ::_exit(0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
    EXPECT_EQ(content(path("redirected.txt")), "before after");
}

} // namespace
} // namespace proxima::output_file_test
