// Numbers as a table or as a drawing of them: by the name of the file.
#pragma once

#include "cli/figure.h"
#include "proxima/execution.h"
#include "proxima/result.h"

#include <string>

namespace proxima {

/// What would go wrong with a file of this name: .csv, .svg and .png are known.
/// Error unsupported_format.
[[nodiscard]] Status check_plot_format(const std::string& path);

/// The table to .csv, the figure to others. Errors: unsupported_format, file_not_writable,
/// cancelled.
[[nodiscard]] Status write_plot(const std::string& csv, const Figure& figure,
                                const std::string& path, Progress* progress = nullptr);

} // namespace proxima
