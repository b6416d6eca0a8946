// Tables of text with aligned columns, for people.
//
//     TextTable table({"Depth", "Method", "Seconds"});
//     table.add_row({"1", "fast", "0.002"});
//     print(table.text());
#pragma once

#include <string>
#include <vector>

namespace proxima {

/// Columns whose cells are all numbers (or empty) stand right, the others left. ASCII only.
class TextTable {
public:
    explicit TextTable(std::vector<std::string> titles);

    /// \pre as many cells as titles
    void add_row(std::vector<std::string> cells);

    /// Title line, rule, rows; every line ends in a newline.
    [[nodiscard]] std::string text() const;

private:
    std::vector<std::vector<std::string>> rows_; // the first holds the titles
};

} // namespace proxima
