#include "base/disjoint_sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace proxima::disjoint_sets_test {
namespace {

TEST(DisjointSets, RootIsTheLowestMember)
{
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        std::mt19937 random(seed);
        const auto below = [&](std::uint32_t limit) {
            return static_cast<std::uint32_t>(random() % limit);
        };
        const std::uint32_t count = 1 + below(20);
        DisjointSets sets(count);
        std::vector<std::uint32_t> labels(count);
        std::iota(labels.begin(), labels.end(), 0U);
        for (std::uint32_t step = below(20); step > 0; --step) {
            const std::uint32_t a = below(count);
            const std::uint32_t b = below(count);
            sets.unite(a, b);
            const auto [low, high] = std::minmax(labels[a], labels[b]);
            std::replace(labels.begin(), labels.end(), std::uint32_t{high}, std::uint32_t{low});
        }
        for (std::uint32_t item = 0; item < count; ++item) {
            EXPECT_EQ(sets.find(item), labels[item]) << "seed " << seed;
        }
    }
}

TEST(DisjointOffsets, FindTheDifferencesOfHiddenNumbers)
{
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        constexpr std::uint32_t count = 60;
        std::vector<std::int64_t> hidden(count);
        for (std::int64_t& number : hidden) number = static_cast<std::int64_t>(random() % 100) - 50;
        DisjointOffsets offsets(count);
        DisjointSets sets(count);
        for (int i = 0; i < 50; ++i) {
            const auto a = static_cast<std::uint32_t>(random() % count);
            const auto b = static_cast<std::uint32_t>(random() % count);
            offsets.unite(a, b, hidden[b] - hidden[a]);
            sets.unite(a, b);
            for (std::uint32_t member = 0; member < count; ++member) {
                const auto found = offsets.find(member);
                EXPECT_EQ(found.smallest, sets.find(member));
                EXPECT_EQ(found.difference, hidden[member] - hidden[found.smallest]);
            }
        }
    }
}

} // namespace
} // namespace proxima::disjoint_sets_test
