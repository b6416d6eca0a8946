// Tables of numbers that commands read: text, or NumPy's .npy; from a file, a pipe or, as "-",
// standard input.
//
//     id,x,y,z           optional: names in any order and letter case, with others between them
//     7,0.5,1e-3,-2      between numbers: commas, semicolons, or spaces and tabs
//     # anything         comments and empty lines are passed over
//
// What numpy.savetxt and pandas write by default is read: a header behind #, an unnamed column of
// row numbers. A first line 0,1,2, which pandas writes for columns without names, is a header where
// every other number of the text has a decimal point or an exponent, as those of floats have. A .npy file holds one array of floats or whole numbers of any size, in C or Fortran
// order, of shape (rows, columns); (rows, 3, 4) has 12 columns, (rows) has one where a table may
// have one, and a single row may be of any shape.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

/// Numbers, row by row.
struct NumberTable {
    std::size_t columns = 0;
    std::vector<double> values;
    std::size_t layout = 0; ///< which of the layouts that were asked for

    [[nodiscard]] std::size_t rows() const noexcept
    {
        return columns == 0 ? 0 : values.size() / columns;
    }
    [[nodiscard]] std::span<const double> row(std::size_t i) const noexcept
    {
        return std::span(values).subspan(columns * i, columns);
    }

    /// Where a row was: "points.csv:7", a line from 1, or "points.npy, row 3", from 0.
    [[nodiscard]] std::string place_of(std::size_t row) const;

    /// Rows of a text whose lines follow each other: first row, its line.
    struct Lines {
        std::size_t row = 0;
        std::uint64_t line = 0;
    };
    std::vector<Lines> lines; ///< none of an array
    std::string name;         ///< of the file

    /// What was taken for what, in a line for people, where the text leaves it open; else empty.
    std::string note = {};
};

/// What a table may hold.
struct TableForm {
    /// Names of columns, such as "x,y,z": without a header the first layout of as many columns, with
    /// one the longest whose names are there.
    std::span<const std::string_view> layouts;
    std::string_view may_be_infinite = {}; ///< names of columns; all others hold finite numbers
};

struct NumberTableOptions {
    Execution execution = {}; ///< stage "reading numbers", steps are bytes; budget: of the table
};

/// Reads the file. About 50 ns per number; the file is read in pieces, so that memory holds the
/// table alone. Errors name the line (from 1) or the row (from 0): file_not_found, malformed_file
/// (no rows, other columns, no number, NaN, infinite, cut off), unsupported_format (other kinds of
/// arrays), budget_exceeded, cancelled.
[[nodiscard]] Result<NumberTable> read_number_table(const std::string& path, const TableForm& form,
                                                    const NumberTableOptions& options = {});

/// Rows of the command line, numbers between commas. Errors call them `name`.
[[nodiscard]] Result<NumberTable> parse_number_rows(std::span<const std::string> rows,
                                                    const TableForm& form, const std::string& name);

} // namespace proxima
