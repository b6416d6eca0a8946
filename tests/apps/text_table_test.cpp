#include "cli/text_table.h"

#include <gtest/gtest.h>

namespace proxima::text_table_test {
namespace {

TEST(TextTable, AlignsNumbersRightAndWordsLeft)
{
    TextTable table({"Depth", "Method", "Seconds"});
    table.add_row({"1", "fast", "0.5"});
    table.add_row({"10", "separating-axis", "12.25"});
    EXPECT_EQ(table.text(), "Depth  Method           Seconds\n"
                            "-------------------------------\n"
                            "    1  fast                 0.5\n"
                            "   10  separating-axis    12.25\n");
}

TEST(TextTable, EmptyCellsAndDashesKeepAColumnNumeric)
{
    TextTable table({"A", "B"});
    table.add_row({"", "-"});
    table.add_row({"100", "2.5"});
    EXPECT_EQ(table.text(), "  A    B\n"
                            "--------\n"
                            "       -\n"
                            "100  2.5\n");
}

TEST(TextTableDeathTest, RowsHaveOneCellPerTitle)
{
    TextTable table({"A", "B"});
    EXPECT_DEATH(table.add_row({"1"}), "check failed");
}

} // namespace
} // namespace proxima::text_table_test
