// Table 2.1 by the thesis's pseudocode as printed, and with its errors put right one by one.
#pragma once

#include "cli/thesis_comparison.h"

namespace proxima {

/// Appends a table and rows to the comparison of Table 2.1.
[[nodiscard]] Status add_printed_rows(const ThesisComparisonOptions& options,
                                      ThesisComparison& comparison);

} // namespace proxima
