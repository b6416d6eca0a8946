#include "cli/printable.h"

#include <gtest/gtest.h>

namespace proxima::printable_test {
namespace {

TEST(Printable, KnowsCharactersThatCanBePrinted)
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

TEST(Printable, ShowsWhatCannotBePrinted)
{
    EXPECT_EQ(printable("a\n\x1b[31m\xff \u00e4\u202e.obj"),
              "a\\x0A\\x1B[31m\\xFF \u00e4\\xE2\\x80\\xAE.obj");
    EXPECT_EQ(printable(std::string_view("\0\xc3", 2)), "\\x00\\xC3");
    EXPECT_EQ(printable(""), "");
}

} // namespace
} // namespace proxima::printable_test
