#include "base/simd.h"

#include <gtest/gtest.h>

namespace proxima::simd_test {
namespace {

TEST(Simd, CanForceEveryTargetAndRestoreTheBest)
{
    const auto targets = simd_targets();
    ASSERT_FALSE(targets.empty());
    const std::string best = current_simd_target();
    for (const SimdTarget& target : targets) {
        force_simd_target(target);
        EXPECT_EQ(current_simd_target(), target.name);
    }
    restore_simd_targets();
    EXPECT_EQ(current_simd_target(), best);
}

} // namespace
} // namespace proxima::simd_test
