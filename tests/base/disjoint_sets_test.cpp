#include "proxima/base/disjoint_sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace proxima {
namespace {

TEST(DisjointSets, TheRootIsTheLowestOfWhatWasUnited)
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

} // namespace
} // namespace proxima
