#include "cli/list_histogram.h"

#include "cli/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>

namespace proxima {
namespace {

/// Borders of bins: 1, 2, 3, ... and then about four to an octave, up past the longest list.
std::vector<double> bin_borders(std::uint32_t longest)
{
    std::vector<double> borders = {1};
    while (borders.back() <= longest) {
        const double next = std::round(borders.back() * std::exp2(0.25));
        borders.push_back(std::max(next, borders.back() + 1));
    }
    return borders;
}

/// Percent of the cells by bin.
std::vector<double> percents(const ListStatistics& lists, const std::vector<double>& borders)
{
    std::vector<double> result(borders.size() - 1);
    std::size_t bin = 0;
    for (std::size_t length = 1; length < lists.weights.size(); ++length) {
        while (borders[bin + 1] <= static_cast<double>(length)) ++bin;
        result[bin] += 100 * lists.weights[length] / lists.total_weight;
    }
    return result;
}

void draw_steps(Plot& plot, const std::vector<double>& borders, const std::vector<double>& heights,
                unsigned color)
{
    // From the first bin that has cells to the last, down to the axis at both ends.
    std::size_t first = 0;
    std::size_t end = heights.size();
    while (first < end && heights[first] == 0) ++first;
    while (end > first && heights[end - 1] == 0) --end;
    double before = 0;
    for (std::size_t bin = first; bin <= end; ++bin) {
        const double height = bin < end ? heights[bin] : 0;
        if (first == end) break;
        plot.figure.lines.push_back(
            {plot.at(borders[bin], before), plot.at(borders[bin], height), color, 3});
        if (bin < end) {
            plot.figure.lines.push_back(
                {plot.at(borders[bin], height), plot.at(borders[bin + 1], height), color, 3});
        }
        before = height;
    }
}

/// Under the steps of a single series.
void fill_bins(Plot& plot, const std::vector<double>& borders, const std::vector<double>& heights)
{
    constexpr unsigned tint = 0xD5E0EB;
    for (std::size_t bin = 0; bin < heights.size(); ++bin) {
        const Vec2 upper_left = plot.at(borders[bin], heights[bin]);
        plot.figure.boxes.push_back({upper_left, plot.at(borders[bin + 1], 0), tint});
    }
}

std::string name_of(const HistogramSeries& series, HistogramOf what)
{
    const auto& [depth, lists] = series;
    if (lists.cells == 0) return fmt::format("depth {}: no outer cell", depth);
    const bool outer = what == HistogramOf::outer_cells;
    const char* const one = outer ? "cell" : "leaf";
    const char* const many = outer ? "cells" : "leaves";
    return fmt::format("depth {}: mean {:.1f}, {} {}", depth, lists.mean, lists.cells,
                       lists.cells == 1 ? one : many);
}

} // namespace

std::string histogram_csv(std::span<const HistogramSeries> series, HistogramOf what)
{
    const bool outer = what == HistogramOf::outer_cells;
    std::string csv = outer ? "depth,features,cells,percent\n" : "depth,triangles,volume_percent\n";
    for (const auto& [depth, lists] : series) {
        for (std::size_t length = 0; length < lists.weights.size(); ++length) {
            const double weight = lists.weights[length];
            if (weight == 0) continue;
            csv += fmt::format("{},{},", depth, length);
            if (outer) csv += fmt::format("{:.0f},", weight);
            csv += fmt::format("{:.6g}\n", 100 * weight / lists.total_weight);
        }
    }
    return csv;
}

Figure histogram_figure(std::span<const HistogramSeries> series, HistogramOf what,
                        const HistogramTitle& title)
{
    std::uint32_t longest = 9;
    for (const HistogramSeries& one : series) longest = std::max(longest, one.lists.max);
    const std::vector<double> borders = bin_borders(longest);
    std::vector<std::vector<double>> heights;
    double highest = 0;
    for (const HistogramSeries& one : series) {
        heights.push_back(percents(one.lists, borders));
        highest = std::max(highest, *std::ranges::max_element(heights.back()));
    }
    constexpr double headroom = 1.05;
    constexpr std::array tops = {5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 75.0, 100.0};
    const auto fitting =
        std::ranges::find_if(tops, [&](double percent) { return percent >= headroom * highest; });
    const double top = fitting == tops.end() ? tops.back() : *fitting;
    const bool outer = what == HistogramOf::outer_cells;
    PlotWords words = {title.title,
                       {title.subtitle},
                       outer ? "features in the list of a cell" : "triangles in the list of a leaf",
                       outer ? "share of the outer cells, percent"
                             : "share of the root's volume, percent",
                       {}};
    for (const HistogramSeries& one : series) words.series.push_back(name_of(one, what));
    Plot plot(logarithmic_scale(1, borders.back()), linear_scale(top), words);
    if (series.size() == 1) fill_bins(plot, borders, heights[0]);
    for (std::size_t i = 0; i < series.size(); ++i)
        draw_steps(plot, borders, heights[i], plot_color(i));
    return std::move(plot.figure);
}

Status write_histogram(std::span<const HistogramSeries> series, HistogramOf what,
                       const HistogramTitle& title, const std::string& path, Progress* progress)
{
    return write_plot([&] { return histogram_csv(series, what); },
                      [&] { return histogram_figure(series, what, title); }, path, progress);
}

} // namespace proxima
