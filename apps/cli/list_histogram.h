// Histograms of list lengths, as a table and as a figure: thesis figure 5.3.
#pragma once

#include "cli/figure.h"
#include "proxima/proximity/list_statistics.h"

#include <span>
#include <string>

namespace proxima {

/// The cells of one octree.
struct HistogramSeries {
    int depth = 0; ///< the deepest level it was allowed
    ListStatistics lists;
};

/// What stands above the figure.
struct HistogramTitle {
    std::string title;
    std::string subtitle;
};

/// `depth,features,cells,percent`, a line for every length that occurs; percent of the depth's
/// cells. Weights are cells.
[[nodiscard]] std::string histogram_csv(std::span<const HistogramSeries> series);

/// Share of cells over length of list, the lengths on a logarithmic scale in steps of at least one.
[[nodiscard]] Figure histogram_figure(std::span<const HistogramSeries> series,
                                      const HistogramTitle& title);

/// What would go wrong with a file of this name: .csv, .svg and .png are known.
/// Error unsupported_format.
[[nodiscard]] Status check_histogram_format(const std::string& path);

/// By extension. Errors: unsupported_format, file_not_writable, cancelled.
[[nodiscard]] Status write_histogram(std::span<const HistogramSeries> series,
                                     const HistogramTitle& title, const std::string& path,
                                     Progress* progress = nullptr);

} // namespace proxima
