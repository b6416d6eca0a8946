// How tables of numbers are read, by format: what number_table.h is made of.
#pragma once

#include "cli/input_bytes.h"
#include "cli/number_table.h"
#include "proxima/result.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

/// Bytes that are read at once; no line may be longer.
inline constexpr std::size_t table_piece = std::size_t{1} << 20U;

/// "x,y,z" has three.
[[nodiscard]] inline std::size_t column_count(std::string_view names)
{
    return 1 + static_cast<std::size_t>(std::ranges::count(names, ','));
}

/// The first layout of so many columns; layouts.size() where there is none.
[[nodiscard]] std::size_t find_layout(const TableForm& form, std::uint64_t columns);

/// "x,y,z takes 3", or of several layouts each.
[[nodiscard]] std::string what_is_taken(const TableForm& form);

/// By column of the layout, whether it may be infinite.
[[nodiscard]] std::vector<bool> infinite_columns(const TableForm& form, std::size_t layout);

/// Makes room for so many numbers. Error budget_exceeded, also where the system has no memory.
[[nodiscard]] Status reserve_numbers(std::vector<double>& values, std::uint64_t count,
                                     const std::string& name, MemoryBudget budget);

/// A table whose first bytes were read.
struct TableStart {
    InputBytes input;
    std::string start;
    bool is_array = false; ///< of NumPy, else text
};

/// Errors: file_not_found, malformed_file (it is empty).
[[nodiscard]] Result<TableStart> open_table(const std::string& path, Progress* progress);

/// Errors as read_number_table.
[[nodiscard]] Result<NumberTable> read_table(TableStart opened, const TableForm& form,
                                             MemoryBudget budget);

enum class FirstLine : std::uint8_t { may_be_header, is_row };

/// `start` is what was read already. Errors as read_number_table.
[[nodiscard]] Result<NumberTable> read_text_table(InputBytes& input, std::string start,
                                                  const TableForm& form, FirstLine first,
                                                  MemoryBudget budget);
[[nodiscard]] Result<NumberTable> read_npy_table(InputBytes& input, std::string start,
                                                 const TableForm& form, MemoryBudget budget);

} // namespace proxima
