#include "base/morton_code.h"

#include <gtest/gtest.h>
#include <random>

namespace proxima::morton_code_test {
namespace {

TEST(MortonCode, InterleavesBits)
{
    std::mt19937 random(1);
    for (int i = 0; i < 1000; ++i) {
        const auto number = [&] { return static_cast<std::uint32_t>(random() >> 11U); };
        const std::array<std::uint32_t, 3> at = {number(), number(), number()};
        std::uint64_t code = 0;
        for (unsigned bit = 0; bit < 3 * morton_bits; ++bit) {
            code |= std::uint64_t{at[bit % 3] >> bit / 3 & 1U} << bit;
        }
        EXPECT_EQ(morton_code(at), code);
        EXPECT_EQ(morton_coordinates(code), at);
    }
}

} // namespace
} // namespace proxima::morton_code_test
