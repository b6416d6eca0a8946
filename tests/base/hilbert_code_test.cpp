#include "base/hilbert_code.h"

#include <algorithm>
#include <cstdlib>
#include <gtest/gtest.h>
#include <vector>

namespace proxima::hilbert_code_test {
namespace {

TEST(HilbertCode, VisitsEveryCellOfACubeThroughSharedFaces)
{
    for (const int bits : {1, 2, 3, 5}) {
        const std::uint32_t cells = 1U << bits;
        std::vector<std::array<std::uint32_t, 3>> walk(std::size_t{cells} * cells * cells,
                                                       {cells, cells, cells});
        for (std::uint32_t x = 0; x < cells; ++x) {
            for (std::uint32_t y = 0; y < cells; ++y) {
                for (std::uint32_t z = 0; z < cells; ++z) {
                    walk.at(hilbert_code({x, y, z}, bits)) = {x, y, z};
                }
            }
        }
        for (std::size_t i = 0; i < walk.size(); ++i) {
            ASSERT_LT(walk[i][0], cells) << "no cell at " << i;
            if (i == 0) continue;
            int steps = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                steps +=
                    std::abs(static_cast<int>(walk[i][axis]) - static_cast<int>(walk[i - 1][axis]));
            }
            EXPECT_EQ(steps, 1) << "step " << i << " of " << bits << " bits";
        }
    }
}

TEST(HilbertCode, NumbersTheLastCellsOfTheLargestCube)
{
    constexpr std::uint32_t last = (1U << morton_bits) - 1;
    std::vector<std::uint64_t> codes;
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
        codes.push_back(hilbert_code(
            {(corner & 1U) * last, (corner >> 1U & 1U) * last, (corner >> 2U & 1U) * last},
            morton_bits));
        EXPECT_LT(codes.back(), std::uint64_t{1} << 3 * morton_bits);
    }
    EXPECT_EQ(codes[0], 0U);
    EXPECT_EQ(*std::max_element(codes.begin(), codes.end()),
              (std::uint64_t{1} << 3 * morton_bits) - 1);
}

} // namespace
} // namespace proxima::hilbert_code_test
