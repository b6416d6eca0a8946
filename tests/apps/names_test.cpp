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

TEST(Names, RecognizesPrintableCharacters)
{
    for (const std::string_view text : {"a", " ", "~", "\u00e4", "\u20ac", "\U0001F407"}) {
        EXPECT_EQ(utf8_length(text), text.size()) << text;
    }
    // Nothing, control characters, strays, cut off, overlong, surrogate, beyond the last.
    for (const std::string_view text :
         {"", "\n", "\x1b[K", "\x7f", "\x80", "\xff", "\xc3", "\xe2\x82", "\xc0\xaf",
          "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xc2\x85"}) {
        EXPECT_EQ(utf8_length(text), 0U);
    }
    // Directions of writing: all of these and none of their neighbours.
    for (const std::string_view text : {"\u202a", "\u202b", "\u202c", "\u202d", "\u202e", "\u2066",
                                        "\u2067", "\u2068", "\u2069"}) {
        EXPECT_EQ(utf8_length(text), 0U);
    }
    for (const std::string_view text : {"\u2029", "\u202f", "\u2065", "\u206a"})
        EXPECT_EQ(utf8_length(text), text.size());
}

TEST(Names, ShowsWhatCannotBePrinted)
{
    EXPECT_EQ(printable("a\n\x1b[31m\xff \u00e4\u202e.obj"),
              "a\\x0A\\x1B[31m\\xFF \u00e4\\xE2\\x80\\xAE.obj");
    EXPECT_EQ(printable(std::string_view("\0\xc3", 2)), "\\x00\\xC3");
    EXPECT_EQ(printable(""), "");
}

} // namespace
} // namespace proxima::names_test
