// Rows of numbers as CSV, with 17 significant digits, or as NumPy's .npy (float64).
#pragma once

#include "cli/answer_table.h"

#include <cstddef>
#include <fmt/format.h>
#include <iterator>
#include <span>

namespace proxima {

inline void append_row(fmt::memory_buffer& text, AnswerFormat format, std::span<const double> row)
{
    if (format == AnswerFormat::npy) {
        const char* const raw = reinterpret_cast<const char*>(row.data());
        text.append(raw, raw + row.size_bytes());
        return;
    }
    for (std::size_t i = 0; i < row.size(); ++i)
        fmt::format_to(std::back_inserter(text), "{}{:.17g}", i == 0 ? "" : ",", row[i]);
    text.push_back('\n');
}

} // namespace proxima
