// Tables of numbers that commands read: CSV with an optional header line, or NumPy's .npy.
//
//     x,y,z              optional, in any letter case
//     0.5,1e-3,-2        a row; spaces beside commas are skipped
//
// A .npy file holds one array of shape (rows, columns), float32 or float64, in C or Fortran order.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

/// Finite numbers, row by row.
struct NumberTable {
    std::size_t columns = 0;
    std::vector<double> values;

    [[nodiscard]] std::size_t rows() const noexcept { return values.size() / columns; }
};

struct NumberTableOptions {
    Execution execution = {}; ///< stage "reading numbers", steps are bytes; budget: of the table
};

/// Reads the file, by its extension as .npy or as CSV. `columns` are their names, "x,y,z". About
/// 50 ns per number; the file is read in pieces, so that memory holds the table alone. Errors name
/// the line (from 1) or the row (from 0): file_not_found, malformed_file (no rows, another number
/// of columns, other names, no number, NaN, infinite, cut off), unsupported_format (other kinds of
/// arrays), budget_exceeded, cancelled.
[[nodiscard]] Result<NumberTable> read_number_table(const std::string& path,
                                                    std::string_view columns,
                                                    const NumberTableOptions& options = {});

} // namespace proxima
