#include "base/grow_buffer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

namespace proxima {
namespace {

TEST(GrowBuffer, KeepsItsContentThroughEveryKindOfGrowthAndShrinking)
{
    // Sizes on both sides of where blocks become pages of their own.
    std::mt19937 random(7);
    GrowBuffer<std::uint32_t> buffer;
    std::vector<std::uint32_t> expected;
    for (int step = 0; step < 60; ++step) {
        const std::size_t size = random() % 3'000'000;
        const std::size_t kept = std::min(size, expected.size());
        buffer.resize(size);
        expected.resize(size);
        for (std::size_t i = kept; i < size; ++i) {
            buffer[i] = expected[i] = static_cast<std::uint32_t>(random());
        }
        if (step % 3 == 0) buffer.shrink_to_fit();
        ASSERT_TRUE(std::equal(buffer.begin(), buffer.end(), expected.begin(), expected.end()))
            << "step " << step;
        ASSERT_GE(buffer.capacity(), buffer.size());
    }
}

TEST(GrowBuffer, MovedFromIsEmpty)
{
    GrowBuffer<int> first;
    for (int i = 0; i < 100; ++i) first.push_back(i);
    first.push_back(first[0]);
    GrowBuffer<int> second = std::move(first);
    EXPECT_EQ(second.size(), 101U);
    EXPECT_EQ(second[99], 99);
    EXPECT_TRUE(first.empty());
    EXPECT_EQ(first.capacity(), 0U);
    first.push_back(3);
    second = std::move(first);
    EXPECT_EQ(second.size(), 1U);
    EXPECT_EQ(second[0], 3);
}

} // namespace
} // namespace proxima
