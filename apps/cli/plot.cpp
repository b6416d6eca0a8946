#include "cli/plot.h"

#include "base/file_extension.h"
#include "base/output_file.h"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <limits>
#include <utility>

namespace proxima {
namespace {

constexpr unsigned ink = 0x222222;
constexpr unsigned gridline = 0xE4E4E4;

// Pixels.
constexpr double left_space = 120;
constexpr double right_space = 40;
constexpr double title_line = 50;
constexpr double note_height = 24;
constexpr double legend_row = 30;
constexpr double below_plot = 90;
constexpr double tick_length = 7;
constexpr double tick_text = 12;
constexpr double axis_text = 14;

/// 1, 2, 5, 10, ...: the ones of all decades that lie in [low, high].
std::vector<double> round_numbers(double low, double high)
{
    std::vector<double> numbers;
    const int first = static_cast<int>(std::floor(std::log10(low)));
    const int last = static_cast<int>(std::floor(std::log10(high)));
    for (int decade = first; decade <= last; ++decade) {
        for (const double part : {1.0, 2.0, 5.0}) {
            const double number = part * std::pow(10.0, decade);
            if (number >= low * 0.9999 && number <= high * 1.0001) numbers.push_back(number);
        }
    }
    return numbers;
}

/// How far along the scale, 0 to 1.
double part_of(const PlotScale& scale, double value)
{
    const double low = scale.ticks.front();
    const double high = scale.ticks.back();
    return scale.is_logarithmic ? std::log(value / low) / std::log(high / low)
                                : (value - low) / (high - low);
}

} // namespace

PlotScale logarithmic_scale(double least, double most)
{
    const std::vector<double> around = round_numbers(least / 10, most * 10);
    const double low = *std::prev(std::ranges::upper_bound(around, least));
    const double high = *std::ranges::lower_bound(around, std::max(most, low * 1.5));
    return {.is_logarithmic = true, .ticks = round_numbers(low, high)};
}

PlotScale linear_scale(double top)
{
    PlotScale scale;
    for (int i = 0; i <= 5; ++i) scale.ticks.push_back(top * i / 5);
    return scale;
}

Plot::Plot(PlotScale x, PlotScale y, const PlotWords& words) : x_(std::move(x)), y_(std::move(y))
{
    lower_left_.x() = left_space;
    upper_right_.x() = figure.width - right_space;
    double line = 0;
    if (!words.title.empty()) {
        line = title_line;
        add_text({left_space, line}, words.title, 18);
    }
    line += 8;
    for (const std::string& note : words.notes) {
        if (note.empty()) continue;
        line += note_height;
        add_text({left_space, line}, note, 12);
    }
    upper_right_.y() = draw_legend(words.series, line + 36) + 20;
    lower_left_.y() = upper_right_.y() + words.height;
    figure.height = static_cast<int>(lower_left_.y() + below_plot);
    draw_grid(words);
}

Vec2 Plot::at(double x, double y) const
{
    const Vec2 part(part_of(x_, x), part_of(y_, y));
    return lower_left_ + part.cwiseProduct(upper_right_ - lower_left_);
}

void Plot::add_text(const Vec2& at, const std::string& text, double size, TextAnchor anchor,
                    TextTurn turn)
{
    figure.texts.push_back({at, text, {size, ink, anchor, turn}});
}

/// From left to right, in as many rows as it takes; returns where it ends.
double Plot::draw_legend(std::span<const std::string> series, double y)
{
    constexpr double stroke = 30;
    constexpr double space = 10;
    double x = left_space;
    for (std::size_t i = 0; i < series.size(); ++i) {
        const double length = stroke + space + text_length(series[i], tick_text);
        if (x > left_space && x + length > upper_right_.x()) {
            x = left_space;
            y += legend_row;
        }
        figure.lines.push_back({{x, y}, {x + stroke, y}, plot_color(i), 4});
        add_text({x + stroke + space, y + 0.5 * tick_text}, series[i], tick_text);
        x += length + 3 * space;
    }
    return y;
}

void Plot::draw_grid(const PlotWords& words)
{
    const Vec2 corner = lower_left_;
    for (const double value : x_.ticks) {
        const double x = at(value, y_.ticks.front()).x();
        figure.lines.push_back({{x, upper_right_.y()}, {x, corner.y()}, gridline, 1});
        figure.lines.push_back({{x, corner.y()}, {x, corner.y() + tick_length}, ink, 2});
        add_text({x, corner.y() + 28}, fmt::format("{:g}", value), tick_text, TextAnchor::middle);
    }
    for (const double value : y_.ticks) {
        const double y = at(x_.ticks.front(), value).y();
        figure.lines.push_back({{corner.x(), y}, {upper_right_.x(), y}, gridline, 1});
        figure.lines.push_back({{corner.x() - tick_length, y}, {corner.x(), y}, ink, 2});
        add_text({corner.x() - 2 * tick_length, y + 0.5 * tick_text}, fmt::format("{:g}", value),
                 tick_text, TextAnchor::end);
    }
    figure.lines.push_back({{corner.x(), upper_right_.y()}, corner, ink, 2});
    figure.lines.push_back({corner, {upper_right_.x(), corner.y()}, ink, 2});
    const Vec2 middle = 0.5 * (lower_left_ + upper_right_);
    add_text({middle.x(), corner.y() + 66}, words.x, axis_text, TextAnchor::middle);
    add_text({40, middle.y()}, words.y, axis_text, TextAnchor::middle, TextTurn::upward);
}

Figure log_plot(std::span<const PlotSeries> series, PlotWords words)
{
    Vec2 least = Vec2::Constant(std::numeric_limits<double>::infinity());
    Vec2 most = Vec2::Zero();
    words.series.clear();
    for (const PlotSeries& one : series) {
        words.series.push_back(one.name);
        for (const Vec2& point : one.points) {
            least = least.cwiseMin(point);
            most = most.cwiseMax(point);
        }
    }
    Plot plot(logarithmic_scale(least.x(), most.x()), logarithmic_scale(least.y(), most.y()),
              words);
    for (std::size_t i = 0; i < series.size(); ++i) {
        const std::vector<Vec2>& points = series[i].points;
        for (std::size_t k = 0; k < points.size(); ++k) {
            const Vec2 here = plot.at(points[k].x(), points[k].y());
            const Vec2 reach(5, 5);
            plot.figure.boxes.push_back({here - reach, here + reach, plot_color(i)});
            if (k == 0) continue;
            const Vec2 before = plot.at(points[k - 1].x(), points[k - 1].y());
            plot.figure.lines.push_back({before, here, plot_color(i), 3});
        }
    }
    return std::move(plot.figure);
}

Status check_plot_format(const std::string& path)
{
    const std::string extension = lower_case_extension(path);
    if (extension == ".csv") return {};
    for (const char* const known : {".svg", ".pdf", ".png"})
        if (extension == known) return check_drawing();
    return fail(ErrorCode::unsupported_format,
                "unknown extension: plots are .csv, .svg, .pdf or .png", path);
}

Status write_plot(const std::function<std::string()>& csv, const std::function<Figure()>& figure,
                  const std::string& path, Progress* progress)
{
    if (Status status = check_plot_format(path); !status) return status;
    if (lower_case_extension(path) != ".csv") return write_figure(figure(), path, progress);
    const std::string table = csv();
    auto output = OutputFile::create(path, {progress, table.size()});
    if (!output) return tl::unexpected(output.error());
    if (Status status = output->write(table); !status) return status;
    return output->commit();
}

} // namespace proxima
