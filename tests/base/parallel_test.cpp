#include "base/parallel.h"
#include "base/progress.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <vector>

namespace proxima::parallel_test {
namespace {

TEST(ParallelFor, CallsEveryIndexOnceForAnyThreadCount)
{
    for (const int threads : {0, 1, 2, 3, 8}) {
        std::vector<int> calls(1000, 0);
        parallel_for(calls.size(), {threads}, [&](std::size_t index) { ++calls[index]; });
        EXPECT_EQ(calls, std::vector<int>(1000, 1)) << threads << " threads";
    }
    EXPECT_GE(thread_count({}), 1);
}

TEST(ParallelFor, TakesAnyNumberOfThreads)
{
    for (const int threads : {1025, 100'000, 1 << 30, std::numeric_limits<int>::max()}) {
        EXPECT_LE(thread_count({threads}), 1024);
        std::vector<int> calls(300, 0);
        parallel_for(calls.size(), {threads}, [&](std::size_t index) { ++calls[index]; });
        EXPECT_EQ(calls, std::vector<int>(300, 1)) << threads << " threads";
    }
}

TEST(ParallelFor, OneThreadKeepsTheOrder)
{
    std::vector<std::size_t> order;
    parallel_for(100, {1}, [&](std::size_t index) { order.push_back(index); });
    std::vector<std::size_t> expected(100);
    std::iota(expected.begin(), expected.end(), std::size_t{0});
    EXPECT_EQ(order, expected);
}

TEST(ParallelChunks, SplitAllItemsAtMultiplesOfTheChunk)
{
    for (const std::size_t count : {0U, 1U, 6U, 7U, 8U, 20U, 21U}) {
        std::vector<std::size_t> sizes(chunk_count(count, 7), 0);
        parallel_chunks(count, 7, {2}, [&](std::size_t first, std::size_t end) {
            EXPECT_EQ(first % 7, 0U);
            sizes[first / 7] += end - first;
        });
        std::vector<std::size_t> expected(count / 7, 7);
        if (count % 7 != 0) expected.push_back(count % 7);
        EXPECT_EQ(sizes, expected) << count << " items";
    }
}

TEST(Progress, CountsAndCancels)
{
    Progress progress;
    EXPECT_STREQ(progress.stage(), "");
    progress.begin_stage("build", 4);
    parallel_for(3, {2}, [&](std::size_t) { progress.advance(1); });
    EXPECT_STREQ(progress.stage(), "build");
    EXPECT_DOUBLE_EQ(progress.fraction(), 0.75);
    EXPECT_FALSE(is_cancelled(&progress));
    EXPECT_FALSE(is_cancelled(nullptr));
    progress.cancel();
    EXPECT_TRUE(is_cancelled(&progress));
}

} // namespace
} // namespace proxima::parallel_test
