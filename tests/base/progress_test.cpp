#include "base/progress.h"

#include <gtest/gtest.h>

namespace proxima::progress_test {
namespace {

TEST(Progress, CancelsItselfAtTheChosenReport)
{
    Progress progress;
    progress.cancel_after(3);
    progress.begin_stage("first", 10);
    progress.advance(5);
    EXPECT_FALSE(progress.cancelled());
    progress.begin_stage("second", 10);
    EXPECT_TRUE(progress.cancelled());
}

TEST(Progress, IsNotCancelledByItself)
{
    Progress progress;
    for (int i = 0; i < 1000; ++i) progress.advance(1);
    EXPECT_FALSE(progress.cancelled());
}

TEST(StageSteps, ReportsStepsInBlocks)
{
    Progress progress;
    StageSteps steps(&progress, "work", 100, 10);
    EXPECT_STREQ(progress.stage(), "work");
    for (int i = 0; i < 9; ++i) EXPECT_TRUE(steps.done(1));
    EXPECT_EQ(progress.fraction(), 0.0);
    EXPECT_TRUE(steps.done(1));
    EXPECT_EQ(progress.fraction(), 0.1);
    EXPECT_TRUE(steps.done(25));
    EXPECT_EQ(progress.fraction(), 0.35);
}

TEST(StageSteps, StopsAtTheNextBlock)
{
    Progress progress;
    StageSteps steps(&progress, "work", 100, 10);
    progress.cancel();
    EXPECT_TRUE(steps.done(9));
    EXPECT_FALSE(steps.done(1));
}

TEST(StageSteps, WorksWithoutAProgress)
{
    StageSteps steps(nullptr, "work", 100, 10);
    for (int i = 0; i < 100; ++i) EXPECT_TRUE(steps.done(1));
}

} // namespace
} // namespace proxima::progress_test
