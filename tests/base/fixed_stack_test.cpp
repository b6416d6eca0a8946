#include "base/fixed_stack.h"

#include <gtest/gtest.h>

namespace proxima::fixed_stack_test {
namespace {

TEST(FixedStack, GivesBackWhatWasPushedLast)
{
    FixedStack<int, 3> stack;
    EXPECT_TRUE(stack.empty());
    stack.push(1);
    stack.push(2);
    EXPECT_EQ(stack.top(), 2);
    EXPECT_EQ(stack.pop(), 2);
    EXPECT_EQ(stack.pop(), 1);
    EXPECT_TRUE(stack.empty());
}

TEST(FixedStackDeathTest, PrintsBothOperandsWhenFullOrEmpty)
{
    FixedStack<int, 1> stack;
    EXPECT_DEATH((void)stack.pop(), "size_ > 0U \\(0 against 0\\)");
    stack.push(1);
    EXPECT_DEATH(stack.push(2), "size_ < Capacity \\(1 against 1\\)");
}

} // namespace
} // namespace proxima::fixed_stack_test
