#include "base/memory_budget.h"

#include <gtest/gtest.h>

namespace proxima::memory_budget_test {
namespace {

TEST(MemoryBudget, SaysWhatIsNeededAndWhatThereIs)
{
    const auto message = [](std::uint64_t needed, std::uint64_t limit) {
        const Status status = check_budget({.bytes = limit}, needed, "the work", "do less");
        return status ? "" : status.error().message;
    };
    EXPECT_EQ(message(46'080'000, 46'080'000), "");
    EXPECT_EQ(message(46'080'001, 46'080'000),
              "the work needs at least 47 MB, the budget is 46 MB: do less");
    EXPECT_EQ(message(47'000'001, 47'000'000),
              "the work needs at least 48 MB, the budget is 47 MB: do less");
    EXPECT_EQ(message(1'000, 999),
              "the work needs at least 1 MB, the budget is 999 bytes: do less");
}

} // namespace
} // namespace proxima::memory_budget_test
