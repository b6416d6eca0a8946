#include "cli/log_plot.h"

#include "cli/plot_style.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <limits>

namespace proxima {

namespace {

constexpr double title_line = 50; // pixels
constexpr double first_note = 82;
constexpr double note_height = 24;
constexpr double legend_space = 40;
constexpr double plot_height = 560;
constexpr double below_plot = 100;

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

/// A logarithmic scale that begins and ends at round numbers round the values.
class Scale {
public:
    Scale(double least, double most, double from, double to) : from_(from), to_(to)
    {
        const std::vector<double> around = round_numbers(least / 10, most * 10);
        low_ = *std::prev(std::ranges::upper_bound(around, least));
        high_ = *std::ranges::lower_bound(around, std::max(most, low_ * 1.5));
    }
    [[nodiscard]] double position(double value) const
    {
        return from_ + (to_ - from_) * std::log(value / low_) / std::log(high_ / low_);
    }
    [[nodiscard]] std::vector<double> ticks() const { return round_numbers(low_, high_); }
    [[nodiscard]] double from() const { return from_; }
    [[nodiscard]] double to() const { return to_; }

private:
    double from_; ///< pixels
    double to_;
    double low_ = 1;
    double high_ = 10;
};

class LogPlot {
public:
    LogPlot(std::span<const PlotSeries> series, const PlotWords& words)
        : series_(series), words_(words),
          top_(first_note + note_height * static_cast<double>(words.notes.size()) + legend_space),
          x_(scale(0, 140, figure_.width - 40.0)), y_(scale(1, top_ + plot_height, top_))
    {
        figure_.height = static_cast<int>(top_ + plot_height + below_plot);
    }

    Figure draw()
    {
        draw_grid();
        draw_words();
        for (std::size_t i = 0; i < series_.size(); ++i) draw_series(i);
        return std::move(figure_);
    }

private:
    [[nodiscard]] Scale scale(int axis, double from, double to) const
    {
        double least = std::numeric_limits<double>::infinity();
        double most = 0;
        for (const PlotSeries& one : series_) {
            for (const Vec2& point : one.points) {
                least = std::min(least, point[axis]);
                most = std::max(most, point[axis]);
            }
        }
        return {least, most, from, to};
    }

    void add_text(const Vec2& at, const std::string& text, double size,
                  TextAnchor anchor = TextAnchor::start, TextTurn turn = TextTurn::level)
    {
        figure_.texts.push_back({at, text, {size, plot_ink, anchor, turn}});
    }

    void draw_grid()
    {
        constexpr double tick = 7;
        for (const double value : x_.ticks()) {
            const double x = x_.position(value);
            figure_.lines.push_back({{x, y_.to()}, {x, y_.from()}, plot_grid, 1});
            figure_.lines.push_back({{x, y_.from()}, {x, y_.from() + tick}, plot_ink, 2});
            add_text({x, y_.from() + 28}, fmt::format("{:g}", value), 15, TextAnchor::middle);
        }
        for (const double value : y_.ticks()) {
            const double y = y_.position(value);
            figure_.lines.push_back({{x_.from(), y}, {x_.to(), y}, plot_grid, 1});
            figure_.lines.push_back({{x_.from() - tick, y}, {x_.from(), y}, plot_ink, 2});
            add_text({x_.from() - 2 * tick, y + 7}, fmt::format("{:g}", value), 15,
                     TextAnchor::end);
        }
        const Vec2 corner(x_.from(), y_.from());
        figure_.lines.push_back({{x_.from(), y_.to()}, corner, plot_ink, 2});
        figure_.lines.push_back({corner, {x_.to(), y_.from()}, plot_ink, 2});
    }

    void draw_words()
    {
        add_text({x_.from(), title_line}, words_.title, 22);
        double y = first_note;
        for (const std::string& note : words_.notes) {
            add_text({x_.from(), y}, note, 14);
            y += note_height;
        }
        add_text({0.5 * (x_.from() + x_.to()), y_.from() + 68}, words_.x, 18, TextAnchor::middle);
        add_text({40, 0.5 * (y_.from() + y_.to())}, words_.y, 18, TextAnchor::middle,
                 TextTurn::upward);
    }

    void draw_series(std::size_t i)
    {
        const PlotSeries& one = series_[i];
        const unsigned color = plot_color(i);
        const auto at = [&](const Vec2& point) {
            return Vec2(x_.position(point.x()), y_.position(point.y()));
        };
        for (std::size_t k = 0; k < one.points.size(); ++k) {
            const Vec2 here = at(one.points[k]);
            const Vec2 reach(5, 5);
            figure_.boxes.push_back({here - reach, here + reach, color});
            if (k > 0) figure_.lines.push_back({at(one.points[k - 1]), here, color, 3});
        }
        const double y = top_ - 30;
        figure_.lines.push_back({{legend_end_, y}, {legend_end_ + 30, y}, color, 4});
        add_text({legend_end_ + 40, y + 7}, one.name, 15);
        legend_end_ += 80 + text_length(one.name, 15);
    }

    Figure figure_;
    std::span<const PlotSeries> series_;
    const PlotWords& words_;
    double top_; ///< of the scales, in pixels
    Scale x_;
    Scale y_;
    double legend_end_ = x_.from(); ///< of what the legend has so far
};

} // namespace

Figure log_plot(std::span<const PlotSeries> series, const PlotWords& words)
{
    return LogPlot(series, words).draw();
}

} // namespace proxima
