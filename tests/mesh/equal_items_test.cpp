#include "mesh/equal_items.h"

#include "mesh/random_soups.h"

#include <gtest/gtest.h>

namespace proxima::equal_items_test {
namespace {

TEST(FirstEqualItems, AgreesWithComparingAllPairs)
{
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        std::mt19937 random(seed);
        std::vector<std::uint32_t> items(below(random, 40));
        for (std::uint32_t& item : items) item = below(random, 10);
        const bool bad_hash = seed % 3 == 0;
        const auto takes_part = [&](std::uint32_t i) { return items[i] != 7; };
        const auto first = first_equal_items(
            static_cast<std::uint32_t>(items.size()), takes_part,
            [&](std::uint32_t i) { return bad_hash ? 5 : mix_bits(0, items[i]); },
            [&](std::uint32_t i, std::uint32_t j) { return items[i] == items[j]; });
        ASSERT_EQ(first.size(), items.size());
        for (std::uint32_t i = 0; i < items.size(); ++i) {
            std::uint32_t expected = i;
            for (std::uint32_t j = 0; takes_part(i) && j < expected; ++j) {
                if (items[j] == items[i]) expected = j;
            }
            EXPECT_EQ(first[i], expected) << "seed " << seed;
        }
    }
}

} // namespace
} // namespace proxima::equal_items_test
