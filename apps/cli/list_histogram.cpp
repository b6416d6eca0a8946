#include "cli/list_histogram.h"

#include "cli/plot_file.h"
#include "cli/plot_style.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>

namespace proxima {
namespace {

constexpr double legend_top = 118; // pixels

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

/// Where the figure's axes are, and what they show.
class Axes {
public:
    Axes(const Figure& figure, double top, double longest, double highest)
        : right_(figure.width - 40.0), top_(top), bottom_(figure.height - 100.0),
          decades_(std::log10(longest)), highest_(highest)
    {}

    [[nodiscard]] Vec2 at(double length, double percent) const
    {
        return {left_ + (right_ - left_) * std::log10(length) / decades_,
                bottom_ - (bottom_ - top_) * percent / highest_};
    }
    [[nodiscard]] double left() const { return left_; }
    [[nodiscard]] double right() const { return right_; }
    [[nodiscard]] double top() const { return top_; }
    [[nodiscard]] double bottom() const { return bottom_; }
    [[nodiscard]] double longest() const { return std::pow(10.0, decades_); }
    [[nodiscard]] double highest() const { return highest_; }

private:
    double left_ = 110;
    double right_;
    double top_;
    double bottom_;
    double decades_;
    double highest_;
};

void draw_axes(Figure& figure, const Axes& axes, HistogramOf what, const HistogramTitle& title)
{
    const auto text = [&](const Vec2& at, const std::string& words, double size, TextAnchor anchor,
                          TextTurn turn = TextTurn::level) {
        figure.texts.push_back({at, words, {size, plot_ink, anchor, turn}});
    };
    // Lengths: 1, 2, 5, 10, ...
    for (int decade = 0; std::pow(10.0, decade) <= axes.longest(); ++decade) {
        for (const double part : {1.0, 2.0, 5.0}) {
            const double length = part * std::pow(10.0, decade);
            if (length > axes.longest() * 1.0001) continue;
            const double x = axes.at(length, 0).x();
            figure.lines.push_back({{x, axes.top()}, {x, axes.bottom()}, plot_grid, 1});
            figure.lines.push_back({{x, axes.bottom()}, {x, axes.bottom() + 7}, plot_ink, 2});
            text({x, axes.bottom() + 28}, fmt::format("{:.0f}", length), 15, TextAnchor::middle);
        }
    }
    const double step = axes.highest() / 5;
    for (int i = 0; i <= 5; ++i) {
        const double y = axes.at(1, i * step).y();
        figure.lines.push_back({{axes.left(), y}, {axes.right(), y}, plot_grid, 1});
        figure.lines.push_back({{axes.left() - 7, y}, {axes.left(), y}, plot_ink, 2});
        text({axes.left() - 14, y + 7}, fmt::format("{:g}", i * step), 15, TextAnchor::end);
    }
    figure.lines.push_back({{axes.left(), axes.top()}, {axes.left(), axes.bottom()}, plot_ink, 2});
    figure.lines.push_back(
        {{axes.left(), axes.bottom()}, {axes.right(), axes.bottom()}, plot_ink, 2});
    const double middle = 0.5 * (axes.left() + axes.right());
    const bool outer = what == HistogramOf::outer_cells;
    text({middle, axes.bottom() + 68},
         outer ? "features in the list of a cell" : "triangles in the list of a leaf", 18,
         TextAnchor::middle);
    text({42, 0.5 * (axes.top() + axes.bottom())},
         outer ? "share of the outer cells, percent" : "share of the root's volume, percent", 18,
         TextAnchor::middle, TextTurn::upward);
    text({axes.left(), 50}, title.title, 22, TextAnchor::start);
    text({axes.left(), 82}, title.subtitle, 14, TextAnchor::start);
}

void draw_steps(Figure& figure, const Axes& axes, const std::vector<double>& borders,
                const std::vector<double>& heights, unsigned color)
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
        figure.lines.push_back(
            {axes.at(borders[bin], before), axes.at(borders[bin], height), color, 3});
        if (bin < end) {
            figure.lines.push_back(
                {axes.at(borders[bin], height), axes.at(borders[bin + 1], height), color, 3});
        }
        before = height;
    }
}

/// Under the steps of a single series.
void fill_bins(Figure& figure, const Axes& axes, const std::vector<double>& borders,
               const std::vector<double>& heights)
{
    constexpr unsigned tint = 0xD5E0EB;
    for (std::size_t bin = 0; bin < heights.size(); ++bin) {
        const Vec2 upper_left = axes.at(borders[bin], heights[bin]);
        figure.boxes.push_back({upper_left, axes.at(borders[bin + 1], 0), tint});
    }
}

constexpr std::size_t legend_columns = 2;
constexpr double legend_row = 30;

/// Above the axes, row by row.
void draw_legend(Figure& figure, const Axes& axes, std::span<const HistogramSeries> series,
                 HistogramOf what)
{
    const bool outer = what == HistogramOf::outer_cells;
    const char* const one = outer ? "cell" : "leaf";
    const char* const many = outer ? "cells" : "leaves";
    constexpr double size = 15;
    const double column = (axes.right() - axes.left()) / legend_columns;
    for (std::size_t i = 0; i < series.size(); ++i) {
        const auto& [depth, lists] = series[i];
        const double x = axes.left() + column * static_cast<double>(i % legend_columns);
        const std::size_t row = i / legend_columns;
        const double y = legend_top + legend_row * static_cast<double>(row);
        figure.lines.push_back({{x, y}, {x + 30, y}, plot_color(i), 4});
        const std::string words =
            lists.cells == 0 ? fmt::format("depth {}: no outer cell", depth)
                             : fmt::format("depth {}: mean {:.1f}, {} {}", depth, lists.mean,
                                           lists.cells, lists.cells == 1 ? one : many);
        figure.texts.push_back({{x + 40, y + size / 2}, words, {size, plot_ink}});
    }
}

double legend_height(std::size_t series)
{
    const std::size_t rows = (series + legend_columns - 1) / legend_columns;
    return legend_row * static_cast<double>(rows);
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
    Figure figure;
    figure.height = 740 + static_cast<int>(legend_height(series.size()));
    const Axes axes(figure, legend_top + legend_height(series.size()), 1.1 * borders.back(), top);
    draw_axes(figure, axes, what, title);
    for (std::size_t i = 0; i < series.size(); ++i)
        draw_steps(figure, axes, borders, heights[i], plot_color(i));
    if (series.size() == 1) fill_bins(figure, axes, borders, heights[0]);
    draw_legend(figure, axes, series, what);
    return figure;
}

Status write_histogram(std::span<const HistogramSeries> series, HistogramOf what,
                       const HistogramTitle& title, const std::string& path, Progress* progress)
{
    return write_plot(histogram_csv(series, what), histogram_figure(series, what, title), path,
                      progress);
}

} // namespace proxima
