#include "base/parallel_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace proxima::parallel_sort_test {
namespace {

TEST(ParallelSort, EqualsAStableSortForAnyNumberOfThreads)
{
    constexpr unsigned key_bits = 63;
    std::mt19937_64 random(7); // also many keys with the same highest digit, and equal ones
    for (const unsigned used_bits : {63U, 40U, 12U, 1U}) {
        std::vector<KeyedIndex> items(70'000);
        for (std::uint32_t i = 0; i < items.size(); ++i)
            items[i] = {random() >> (64 - used_bits), i};
        std::vector<KeyedIndex> truth = items;
        std::ranges::stable_sort(truth, {}, &KeyedIndex::key);
        for (const int threads : {1, 2, 3}) {
            GrowBuffer<KeyedIndex> sorted;
            sorted.resize(items.size());
            std::ranges::copy(items, sorted.begin());
            ASSERT_TRUE(sort_keys(sorted, key_bits, {threads}, nullptr));
            for (std::size_t i = 0; i < truth.size(); ++i) {
                ASSERT_EQ(sorted[i].key, truth[i].key) << used_bits << " bits, at " << i;
                ASSERT_EQ(sorted[i].index, truth[i].index) << used_bits << " bits, at " << i;
            }
        }
    }
}

TEST(ParallelSort, StopsOnRequest)
{
    Progress progress;
    progress.cancel();
    GrowBuffer<KeyedIndex> items;
    items.resize(20'000);
    std::ranges::fill(items.span(), KeyedIndex());
    EXPECT_FALSE(sort_keys(items, 63, {2}, &progress));
}

} // namespace
} // namespace proxima::parallel_sort_test
