#include "base/grow_buffer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

namespace proxima::grow_buffer_test {
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
    EXPECT_TRUE(first.empty()); // NOLINT(bugprone-use-after-move): that is what is tested
    EXPECT_EQ(first.capacity(), 0U);
    first.push_back(3);
    second = std::move(first);
    EXPECT_EQ(second.size(), 1U);
    EXPECT_EQ(second[0], 3);
}

TEST(PageReserve, GivesBuffersPagesOfTheirOwn)
{
    // Blocks of many sizes come and go in any order: none may lie in another, whatever pages it got.
    constexpr unsigned seed = 11;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const PageReserve reserve;
    std::vector<GrowBuffer<std::uint32_t>> buffers(8);
    for (std::uint32_t step = 0; step < 200; ++step) {
        const std::uint32_t changed = random() % 8;
        GrowBuffer<std::uint32_t>& buffer = buffers[changed];
        const std::size_t before = buffer.size();
        if (random() % 3 == 0) {
            buffer = {};
        } else {
            buffer.resize(random() % 6'000'000);
        }
        if (random() % 4 == 0) buffer.shrink_to_fit();
        for (std::size_t i = before; i < buffer.size(); ++i)
            buffer[i] = changed + 8 * static_cast<std::uint32_t>(i);
        for (std::uint32_t k = 0; k < 8; ++k) {
            for (std::size_t i = 0; i < buffers[k].size(); i += 1023)
                ASSERT_EQ(buffers[k][i], k + 8 * static_cast<std::uint32_t>(i)) << "step " << step;
        }
    }
}

#ifdef __linux__
TEST(PageReserve, LetsABufferUseThePagesOfTheOneBefore)
{
    const PageReserve reserve;
    GrowBuffer<std::uint32_t> first;
    first.resize(8'000'000);
    const std::uint32_t* const memory = first.data();
    first = {};
    GrowBuffer<std::uint32_t> half;
    half.resize(4'000'000);
    EXPECT_EQ(half.data(), memory);
    GrowBuffer<std::uint32_t> rest;
    rest.resize(2'000'000);
    EXPECT_GT(rest.data(), half.data());
    EXPECT_LT(rest.data(), memory + 8'000'000);
}
#endif

} // namespace
} // namespace proxima::grow_buffer_test
