#include "cli/text_table.h"

#include "base/check.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace proxima {

namespace {

bool is_number(std::string_view cell)
{
    return cell.empty() || cell == "-" ||
           cell.find_first_not_of("+-.0123456789e%x ") == std::string_view::npos;
}

} // namespace

TextTable::TextTable(std::vector<std::string> titles)
{
    rows_.push_back(std::move(titles));
}

void TextTable::add_row(std::vector<std::string> cells)
{
    PROXIMA_CHECK(cells.size() == rows_.front().size());
    rows_.push_back(std::move(cells));
}

std::string TextTable::text() const
{
    const std::size_t columns = rows_.front().size();
    std::vector<std::size_t> widths(columns, 0);
    std::vector<bool> right(columns, true);
    for (std::size_t row = 0; row < rows_.size(); ++row) {
        for (std::size_t column = 0; column < columns; ++column) {
            const std::string& cell = rows_[row][column];
            widths[column] = std::max(widths[column], cell.size());
            if (row > 0 && !is_number(cell)) right[column] = false;
        }
    }
    std::string text;
    for (std::size_t row = 0; row < rows_.size(); ++row) {
        std::string line;
        for (std::size_t column = 0; column < columns; ++column) {
            const std::string& cell = rows_[row][column];
            const std::string padding(widths[column] - cell.size(), ' ');
            if (column > 0) line += "  ";
            line += right[column] ? padding + cell : cell + padding;
        }
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + '\n';
        if (row == 0) {
            std::size_t width = 2 * (columns - 1);
            for (const std::size_t column_width : widths) width += column_width;
            text += std::string(width, '-') + '\n';
        }
    }
    return text;
}

} // namespace proxima
