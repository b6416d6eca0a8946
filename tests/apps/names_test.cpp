#include "cli/names.h"

#include <gtest/gtest.h>

namespace proxima::names_test {
namespace {

TEST(Names, EveryMethodIsFoundByItsName)
{
    for (const OverlapMethod method : all_methods) {
        EXPECT_EQ(find_method(method_name(method)), method);
    }
    EXPECT_EQ(find_method("quick"), std::nullopt);
    EXPECT_EQ(find_method(""), std::nullopt);
    EXPECT_EQ(method_names(), "fast, separating-axis, index-tracking, minkowski, pairwise");
}

TEST(Names, ListsOfNumbersTakeRangesInAnyOrder)
{
    using Numbers = std::vector<int>;
    EXPECT_EQ(parse_numbers("1-5", 0, 19), (Numbers{1, 2, 3, 4, 5}));
    EXPECT_EQ(parse_numbers("7", 0, 19), (Numbers{7}));
    EXPECT_EQ(parse_numbers("5,1-3,2", 0, 19), (Numbers{1, 2, 3, 5}));
    EXPECT_EQ(parse_numbers("0-0", 0, 19), (Numbers{0}));
}

TEST(Names, RefusesWrongListsOfNumbers)
{
    for (const char* const text :
         {"", ",", "1,", "-", "-1", "1-", "3-1", "a", "1-20", "20", "1 2", "1--2", "99999999999"}) {
        EXPECT_EQ(parse_numbers(text, 0, 19), std::nullopt) << text;
    }
}

TEST(Names, ParsesFiniteNumbersOfALine)
{
    using Numbers = std::vector<double>;
    EXPECT_EQ(parse_finite_numbers("1,-2.5e3,.25"), (Numbers{1, -2500, 0.25}));
    EXPECT_EQ(parse_finite_numbers("0.1"), (Numbers{0.1}));
    for (const char* const text :
         {"", ",", "1,", "a", "nan", "inf", "1,-inf", "1e999", "0x10", "1 2", "1, 2", "+1"}) {
        EXPECT_EQ(parse_finite_numbers(text), std::nullopt) << text;
    }
}

TEST(Names, SplittingKeepsEmptyParts)
{
    EXPECT_EQ(split_list("a,,b"), (std::vector<std::string>{"a", "", "b"}));
    EXPECT_EQ(split_list(""), (std::vector<std::string>{""}));
}

} // namespace
} // namespace proxima::names_test
