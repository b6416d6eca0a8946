// Plots: curves over two scales, drawn as a figure or written as the table of their numbers.
//
//     Plot plot(logarithmic_scale(1, 500), linear_scale(40), {.title = "...", .series = {"first"}});
//     plot.figure.lines.push_back({plot.at(1, 10), plot.at(2, 20), plot_color(0), 3});
//     write_plot(csv, plot.figure, "plot.svg");
#pragma once

#include "cli/figure.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace proxima {

/// The colour of the series of this number, of colours that everybody tells apart [Tol's bright
/// scheme].
[[nodiscard]] constexpr unsigned plot_color(std::size_t series) noexcept
{
    constexpr std::array palette = {0x4477AAU, 0xEE6677U, 0x228833U,
                                    0xCCBB44U, 0x66CCEEU, 0xAA3377U};
    return palette[series % palette.size()];
}

struct PlotScale {
    bool is_logarithmic = false;
    std::vector<double> ticks; ///< ascending; the scale goes from the first to the last
};

/// Through 1, 2, 5, 10, ..., as far as the values go. \pre 0 < least <= most, finite
[[nodiscard]] PlotScale logarithmic_scale(double least, double most);

/// Five steps from zero. \pre top > 0
[[nodiscard]] PlotScale linear_scale(double top);

struct PlotWords {
    std::string title = {};              ///< may be empty
    std::vector<std::string> notes = {}; ///< lines below the title
    std::string x = {};
    std::string y = {};
    std::vector<std::string> series = {}; ///< the legend, in the colours of plot_color
    double height = 560;                  ///< of the axes, pixels
};

class Plot {
public:
    /// The figure with its words and an empty grid.
    Plot(PlotScale x, PlotScale y, const PlotWords& words);

    [[nodiscard]] Vec2 at(double x, double y) const;

    Figure figure;

private:
    void draw_grid(const PlotWords& words);
    void add_text(const Vec2& at, const std::string& text, double size,
                  TextAnchor anchor = TextAnchor::start, TextTurn turn = TextTurn::level);
    double draw_legend(std::span<const std::string> series, double y);

    PlotScale x_;
    PlotScale y_;
    Vec2 lower_left_ = Vec2::Zero(); ///< pixels
    Vec2 upper_right_ = Vec2::Zero();
};

struct PlotSeries {
    std::string name;
    std::vector<Vec2> points; ///< x ascending
};

/// The points of each series, joined in their order, over two logarithmic scales; `words.series`
/// is not heeded. \pre coordinates are positive and finite, and there is a point
[[nodiscard]] Figure log_plot(std::span<const PlotSeries> series, PlotWords words);

/// What would go wrong with a file of this name: .csv, .svg, .pdf and .png are known.
/// Errors: unsupported_format; those of check_drawing for others than .csv.
[[nodiscard]] Status check_plot_format(const std::string& path);

/// The table to .csv, the figure to others; the other one is not made. Errors: unsupported_format, file_not_writable,
/// cancelled.
[[nodiscard]] Status write_plot(const std::function<std::string()>& csv,
                                const std::function<Figure()>& figure, const std::string& path,
                                Progress* progress = nullptr);

} // namespace proxima
