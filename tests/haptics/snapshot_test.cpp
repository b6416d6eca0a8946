#include "haptics/loop/snapshot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

namespace proxima::snapshot_test {
namespace {

/// Large enough to be torn, were it possible.
struct Page {
    std::array<std::uint64_t, 64> words{};
};

TEST(Snapshot, GivesTheNewestValueOnce)
{
    Snapshot<int> snapshot(7);
    EXPECT_FALSE(snapshot.update());
    EXPECT_EQ(snapshot.reading(), 7);
    for (int value = 1; value < 10; ++value) {
        snapshot.writing() = value;
        snapshot.publish();
        if (value % 3 != 0) continue;
        EXPECT_TRUE(snapshot.update());
        EXPECT_EQ(snapshot.reading(), value);
        EXPECT_FALSE(snapshot.update());
        EXPECT_EQ(snapshot.reading(), value);
    }
}

TEST(Snapshot, KeepsTheValueBefore)
{
    Snapshot<Page, 2> snapshot;
    std::uint64_t now = 0;
    std::uint64_t before = 0;
    for (std::uint64_t value = 1; value < 200; ++value) {
        snapshot.writing().words.fill(value);
        snapshot.publish();
        // The writer is up to three values ahead: it overwrites none that the reader keeps.
        if (value % 5 != 0 && value % 7 != 0) continue;
        EXPECT_EQ(snapshot.reading().words[9], now);
        EXPECT_EQ(snapshot.before().words[9], before);
        ASSERT_TRUE(snapshot.update());
        before = now;
        now = value;
        EXPECT_EQ(snapshot.reading().words[9], now);
        EXPECT_EQ(snapshot.before().words[9], before);
        EXPECT_FALSE(snapshot.update());
        EXPECT_EQ(snapshot.before().words[9], before);
    }
}

TEST(Snapshot, IsNeverTornAndNeverGoesBack)
{
    constexpr std::uint64_t last = 200000;
    Snapshot<Page> snapshot;
    std::thread writer([&] {
        for (std::uint64_t round = 1; round <= last; ++round) {
            snapshot.writing().words.fill(round);
            snapshot.publish();
        }
    });
    std::uint64_t seen = 0;
    std::uint64_t updates = 0;
    while (seen < last) {
        if (!snapshot.update()) {
            std::this_thread::yield();
            continue;
        }
        const Page& page = snapshot.reading();
        const auto [least, most] = std::minmax_element(page.words.begin(), page.words.end());
        ASSERT_EQ(*least, *most);
        ASSERT_GT(*least, seen);
        seen = *least;
        ++updates;
    }
    writer.join();
    EXPECT_GT(updates, 0U);
    EXPECT_FALSE(snapshot.update());
}

} // namespace
} // namespace proxima::snapshot_test
