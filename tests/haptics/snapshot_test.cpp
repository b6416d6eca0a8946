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

// The writer goes on until the reader has seen enough: a thread may start long after another.
TEST(Snapshot, IsNeverTornAndNeverGoesBack)
{
    constexpr int enough = 1000;
    Snapshot<Page> snapshot;
    std::atomic<bool> ending{false};
    std::uint64_t last = 0;
    std::thread writer([&] {
        while (!ending.load()) {
            snapshot.writing().words.fill(++last);
            snapshot.publish();
        }
    });
    std::uint64_t seen = 0;
    int torn = 0;
    int back = 0;
    const auto look = [&] {
        const Page& page = snapshot.reading();
        const auto [least, most] = std::minmax_element(page.words.begin(), page.words.end());
        torn += *least != *most ? 1 : 0;
        back += *least <= seen ? 1 : 0;
        seen = *least;
    };
    for (int updates = 0; updates < enough;) {
        if (!snapshot.update()) {
            std::this_thread::yield();
            continue;
        }
        look();
        ++updates;
    }
    ending.store(true);
    writer.join();
    if (snapshot.update()) look();
    EXPECT_EQ(torn, 0);
    EXPECT_EQ(back, 0);
    EXPECT_EQ(seen, last);
    EXPECT_FALSE(snapshot.update());
}

} // namespace
} // namespace proxima::snapshot_test
