// Histograms of list lengths, as a table and as a figure: thesis figure 5.3.
#pragma once

#include "cli/figure.h"
#include "thesis/proximity_octree/list_statistics.h"

#include <cstdint>
#include <span>
#include <string>

namespace proxima {

/// The cells of one octree, with weights of 1 or of their volumes.
struct HistogramSeries {
    int depth = 0; ///< the deepest level it was allowed
    ListStatistics lists;
};

/// Whose lists are shown, and what they are weighed by.
enum class HistogramOf : std::uint8_t {
    outer_cells, ///< features of the thesis's outer cells, each cell the same
    leaves       ///< triangles of all leaves, by volume
};

/// What stands above the figure.
struct HistogramTitle {
    std::string title; ///< may be empty
    std::string subtitle;
};

/// A line for every length that occurs: `depth,features,cells,percent` of outer cells, percent of
/// the depth's cells; `depth,triangles,volume_percent` of leaves.
[[nodiscard]] std::string histogram_csv(std::span<const HistogramSeries> series, HistogramOf what);

/// Share of cells or volume over length of list, the lengths on a logarithmic scale in steps of at
/// least one.
[[nodiscard]] Figure histogram_figure(std::span<const HistogramSeries> series, HistogramOf what,
                                      const HistogramTitle& title);

/// By extension. Errors: unsupported_format, file_not_writable, cancelled.
[[nodiscard]] Status write_histogram(std::span<const HistogramSeries> series, HistogramOf what,
                                     const HistogramTitle& title, const std::string& path,
                                     Progress* progress = nullptr);

} // namespace proxima
