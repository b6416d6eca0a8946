#include "haptics/channel/shared_segment.h"

#include "haptics/engine_side.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstring>
#include <functional>
#include <iostream>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

namespace proxima::shared_segment_test {
namespace {

using namespace testing;

bool exists(const std::string& name)
{
    struct stat there {};
    return stat(("/dev/shm/proxima-" + name).c_str(), &there) == 0;
}

/// The status of a child process that calls a function, and ends with what that returns.
int status_of_child(const std::function<int()>& function)
{
    const pid_t child = fork();
    if (child == 0) _exit(function()); // without destructors, as if it were killed
    int status = 0;
    waitpid(child, &status, 0);
    return status;
}

TEST(SharedSegment, IsForThisUserAloneAndIsRemoved)
{
    const std::string name = segment_name("alone");
    {
        const auto segment = SharedSegment::create(name);
        ASSERT_TRUE(segment) << describe(segment.error());
        struct stat there {};
        ASSERT_EQ(stat(("/dev/shm/proxima-" + name).c_str(), &there), 0);
        EXPECT_EQ(there.st_mode & 0777U, 0600U);
        EXPECT_EQ(static_cast<std::size_t>(there.st_size), segment_size);
        EXPECT_EQ(std::memcmp(segment->bytes().data(), "PXSM\x02\0\0\x01\x04\x03\x02\x01", 12), 0);
        // A second owner is refused in words.
        const auto second = SharedSegment::create(name);
        ASSERT_FALSE(second);
        EXPECT_NE(second.error().message.find("in use by another program"), std::string::npos);
    }
    EXPECT_FALSE(exists(name));
    EXPECT_TRUE(SharedSegment::create(name));
    EXPECT_FALSE(exists(name));
}

TEST(SharedSegment, ThatAKilledProgramLeftIsTakenOver)
{
    const std::string name = segment_name("stale");
    ASSERT_EQ(status_of_child([&] {
                  const auto segment = SharedSegment::create(name);
                  if (!segment) return 1;
                  std::memset(segment->bytes().data() + 64, 0xff, segment_size - 64);
                  _exit(0);
              }),
              0);
    ASSERT_TRUE(exists(name));
    const auto segment = SharedSegment::create(name);
    ASSERT_TRUE(segment) << describe(segment.error());
    EXPECT_EQ(packets_written(segment->bytes(), scene_ring), 0U);
    EXPECT_TRUE(std::ranges::all_of(segment->bytes().subspan(64),
                                    [](std::byte b) { return b == std::byte{0}; }));
}

// An owner that is killed before it writes the header leaves zeros.
TEST(SharedSegment, ThatWasNeverFinishedIsTakenOver)
{
    const std::string name = segment_name("unfinished");
    const std::string path = "/proxima-" + name;
    const int file = shm_open(path.c_str(), O_RDWR | O_CREAT | O_EXCL, 0600);
    ASSERT_GE(file, 0);
    EXPECT_EQ(ftruncate(file, off_t{segment_size}), 0);
    close(file);
    const auto segment = SharedSegment::create(name);
    EXPECT_TRUE(segment) << describe(segment.error());
    if (!segment) shm_unlink(path.c_str());
}

TEST(SharedSegment, ThatCannotBeMadeLeavesNoName)
{
    const std::string name = segment_name("no-room");
    EXPECT_EQ(status_of_child([&] {
                  const rlimit small = {4096, 4096};
                  (void)std::signal(SIGXFSZ, SIG_IGN);
                  if (setrlimit(RLIMIT_FSIZE, &small) != 0) return 1;
                  return SharedSegment::create(name) ? 2 : 0;
              }),
              0);
    EXPECT_FALSE(exists(name));
    shm_unlink(("/proxima-" + name).c_str());
}

// Somebody removed the name, and another program took it.
TEST(SharedSegment, LeavesTheSegmentOfAnotherOwnerAlone)
{
    const std::string name = segment_name("renamed");
    auto first = SharedSegment::create(name);
    ASSERT_TRUE(first);
    ASSERT_EQ(shm_unlink(first->path().c_str()), 0);
    const auto second = SharedSegment::create(name);
    ASSERT_TRUE(second) << describe(second.error());
    {
        const SharedSegment ending = std::move(*first);
    }
    EXPECT_TRUE(exists(name));
}

// An engine that asks whether a stale segment has an owner holds a lock for a moment.
TEST(SharedSegment, IsTakenOverWhileAnEngineLooksAtIt)
{
    const std::string name = segment_name("looked-at");
    const int file = shm_open(("/proxima-" + name).c_str(), O_RDWR | O_CREAT | O_EXCL, 0600);
    ASSERT_GE(file, 0);
    ASSERT_EQ(flock(file, LOCK_SH | LOCK_NB), 0);
    std::thread engine([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        flock(file, LOCK_UN);
    });
    const auto segment = SharedSegment::create(name);
    EXPECT_TRUE(segment) << describe(segment.error());
    engine.join();
    close(file);
    if (!segment) shm_unlink(("/proxima-" + name).c_str());
}

TEST(SharedSegment, LeavesWhatIsNotItsOwnAlone)
{
    const std::string name = segment_name("foreign");
    const std::string path = "/proxima-" + name;
    const int file = shm_open(path.c_str(), O_RDWR | O_CREAT | O_EXCL, 0600);
    ASSERT_GE(file, 0);
    ASSERT_EQ(write(file, "precious", 8), 8);
    const auto segment = SharedSegment::create(name);
    ASSERT_FALSE(segment);
    EXPECT_NE(segment.error().message.find("no segment of ours"), std::string::npos);
    std::array<char, 8> left{};
    EXPECT_EQ(pread(file, left.data(), 8, 0), 8);
    EXPECT_EQ(std::memcmp(left.data(), "precious", 8), 0);
    close(file);
    shm_unlink(path.c_str());
}

// A writer overwrites a slot again and again while it is read: what is read is whole.
TEST(SharedSegment, PacketsAreWholeOrNotThere)
{
    const std::string name = segment_name("torn");
    const auto segment = SharedSegment::create(name);
    ASSERT_TRUE(segment);
    const MappedSegment other(name);
    constexpr std::uint64_t most_attempts = 4'000'000;
    constexpr std::uint64_t enough = 3000;
    constexpr std::size_t size = 9000; // long, so that many are overwritten while they are read
    const auto number_of = [](std::uint64_t n) { return n * scene_ring.slots; }; // all in a slot
    std::atomic<bool> ending{false};
    std::thread writer([&] {
        std::vector<std::byte> packet(size);
        std::vector<std::byte> copy(size);
        for (std::uint64_t n = 0; !ending.load(); ++n) {
            std::memset(packet.data(), static_cast<int>(n % 251), size);
            packet[6] = std::byte{size & 0xff};
            packet[7] = std::byte{size >> 8};
            write_packet(other.bytes(), scene_ring, number_of(n), packet);
            // A pause that is as long as the reader takes to copy.
            for (int i = 0; i < 3; ++i)
                (void)read_packet(other.bytes(), scene_ring, number_of(n), copy);
        }
    });
    while (packets_written(segment->bytes(), scene_ring) == 0) std::this_thread::yield();
    std::vector<std::byte> buffer(size);
    std::uint64_t whole = 0;
    std::uint64_t gone = 0;
    std::uint64_t torn = 0;
    const auto read = [&] {
        const std::uint64_t written = packets_written(segment->bytes(), scene_ring);
        if (read_packet(segment->bytes(), scene_ring, written - 1, buffer) != size) {
            ++gone;
            return;
        }
        ++whole;
        const std::uint64_t n = (written - 1) / scene_ring.slots;
        const auto expected = static_cast<std::byte>(n % 251);
        const auto is_other = [&](std::byte b) { return b != expected; };
        torn += std::any_of(buffer.begin() + 8, buffer.end(), is_other) ? 1U : 0U;
    };
    while (whole < enough && gone < most_attempts) read();
    ending.store(true);
    writer.join();
    read();
    EXPECT_EQ(torn, 0U);
    EXPECT_GT(whole, 0U);
    std::cout << whole << " packets whole, " << gone << " overwritten meanwhile\n";
}

// A writer that died within a packet leaves an odd number; the next one's packets are read.
TEST(SharedSegment, AWriterThatDiesLeavesNothingLocked)
{
    const auto segment = SharedSegment::create(segment_name("died"));
    ASSERT_TRUE(segment);
    const std::vector<std::byte> packet = bytes_of(scene_packet(1, 0));
    std::vector<std::byte> buffer(most_scene_packet_size);
    write_packet(segment->bytes(), scene_ring, 0, packet);
    const std::uint64_t odd = 2 * 64 + 1; // packet 64 is for the same slot
    std::memcpy(segment->bytes().data() + scene_ring.offset, &odd, sizeof odd);
    EXPECT_EQ(read_packet(segment->bytes(), scene_ring, 0, buffer), 0U);
    EXPECT_EQ(read_packet(segment->bytes(), scene_ring, 64, buffer), 0U);
    write_packet(segment->bytes(), scene_ring, 64, packet);
    EXPECT_EQ(read_packet(segment->bytes(), scene_ring, 64, buffer), packet.size());
}

// A signal that another process sent is no access to memory: it ends the program as before.
TEST(TruncationGuard, DoesNotSwallowSignalsThatWereSent)
{
    alignas(64) std::array<std::byte, 64> memory{};
    EXPECT_NE(status_of_child([&] {
                  const TruncationGuard guard(memory);
                  kill(getpid(), SIGBUS);
                  return 0;
              }),
              0);
}

} // namespace
} // namespace proxima::shared_segment_test
