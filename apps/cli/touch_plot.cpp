#include "cli/touch_plot.h"

#include "cli/plot.h"
#include "cli/touch_device.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/core.h>
#include <iterator>
#include <span>
#include <string_view>
#include <utility>

namespace proxima {
namespace {

constexpr double panel_height = 190;
constexpr std::size_t columns = 1040; ///< of the plot: more ticks are joined

constexpr unsigned fault_color = 0xF4C7CD;
constexpr unsigned band_free = 0xE4E4E4;
constexpr unsigned band_sliding = 0xCCBB44;
constexpr unsigned band_sticking = 0x228833;

/// The smallest of 1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10 times a power of ten that is not below.
double round_top(double most)
{
    if (!(most > 0)) return 1;
    const double decade = std::pow(10.0, std::floor(std::log10(most)));
    constexpr std::array parts = {1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0};
    const auto fitting =
        std::ranges::find_if(parts, [&](double part) { return part * decade >= most; });
    return (fitting == parts.end() ? 10.0 : *fitting) * decade;
}

double seconds_at(const TouchTrace& trace, std::size_t tick)
{
    return static_cast<double>(tick) * trace.tick_seconds;
}

/// Calls visit(first, end) for runs of ticks, one for each column at most.
template <class Visit>
void for_each_column(std::size_t ticks, Visit&& visit)
{
    const std::size_t runs = std::min(ticks, columns);
    for (std::size_t i = 0; i < runs; ++i) visit(i * ticks / runs, (i + 1) * ticks / runs);
}

/// What a panel shows of a tick.
using TickValue = double (*)(const TracedTick&);

double force_of(const TracedTick& tick)
{
    return tick.force.norm();
}
double millimetres_of(const TracedTick& tick)
{
    return 1e3 * tick.depth;
}
double share_of(const TracedTick& tick)
{
    return tick.share;
}

struct Panel {
    const char* axis;
    TickValue value;
    double top; ///< of the scale; 0 for what the values need
    unsigned color;
};

/// Draws a curve. Where a column has several ticks it goes from the least to the most of them, so no
/// peak is lost.
void draw_curve(Plot& plot, const TouchTrace& trace, const Panel& panel)
{
    Vec2 before = Vec2::Zero();
    for_each_column(trace.ticks.size(), [&](std::size_t first, std::size_t end) {
        double least = panel.value(trace.ticks[first]);
        double most = least;
        for (std::size_t i = first; i < end; ++i) {
            least = std::min(least, panel.value(trace.ticks[i]));
            most = std::max(most, panel.value(trace.ticks[i]));
        }
        const double seconds = seconds_at(trace, first);
        const Vec2 begin = plot.at(seconds, panel.value(trace.ticks[first]));
        if (first > 0) plot.figure.lines.push_back({before, begin, panel.color, 2});
        if (most > least) {
            plot.figure.lines.push_back(
                {plot.at(seconds, least), plot.at(seconds, most), panel.color, 2});
        }
        before = plot.at(seconds, panel.value(trace.ticks[end - 1]));
    });
}

bool is_fault(const TracedTick& tick)
{
    return tick.condition != InputCondition::well && tick.condition != InputCondition::released;
}

/// Tints the time in which the input was at fault.
void tint_faults(Plot& plot, const TouchTrace& trace, double top)
{
    for_each_column(trace.ticks.size(), [&](std::size_t first, std::size_t end) {
        const auto run = std::span(trace.ticks).subspan(first, end - first);
        if (std::ranges::none_of(run, is_fault)) return;
        plot.figure.boxes.push_back({plot.at(seconds_at(trace, first), top),
                                     plot.at(seconds_at(trace, end), 0), fault_color});
    });
}

unsigned color_of(Hold hold)
{
    if (hold == Hold::free) return band_free;
    return hold == Hold::sticking ? band_sticking : band_sliding;
}

/// A band along the lower end of a panel: the most frequent hold of each column.
void draw_band(Plot& plot, const TouchTrace& trace)
{
    constexpr double band_height = 12;
    for_each_column(trace.ticks.size(), [&](std::size_t first, std::size_t end) {
        std::array<std::size_t, 3> counts = {};
        for (std::size_t i = first; i < end; ++i)
            ++counts[static_cast<std::size_t>(trace.ticks[i].hold)];
        const auto most = std::ranges::max_element(counts) - counts.begin();
        const Vec2 lower = plot.at(seconds_at(trace, first), 0);
        const Vec2 upper = plot.at(seconds_at(trace, end), 0);
        plot.figure.boxes.push_back(
            {lower - Vec2(0, band_height), upper, color_of(static_cast<Hold>(most))});
    });
}

/// Moves what one figure draws below what another one does.
void put_below(Figure& figure, Figure&& part)
{
    const Vec2 down(0, figure.height);
    for (FigureBox& box : part.boxes)
        figure.boxes.push_back({box.lower + down, box.upper + down, box.color, box.opacity});
    for (FigureLine& line : part.lines)
        figure.lines.push_back({line.from + down, line.to + down, line.color, line.width});
    for (FigureText& text : part.texts)
        figure.texts.push_back({text.at + down, std::move(text.text), text.style});
    figure.height += part.height;
}

/// The legend of tints and bands.
void draw_keys(Figure& figure, double y)
{
    constexpr std::array<std::pair<unsigned, const char*>, 4> keys = {
        {{band_free, "free"},
         {band_sliding, "sliding"},
         {band_sticking, "sticking"},
         {fault_color, "input not well"}}};
    double x = 120;
    for (const auto& [color, text] : keys) {
        figure.boxes.push_back({{x, y - 12}, {x + 30, y}, color});
        figure.texts.push_back({{x + 40, y}, text, {12, 0x222222}});
        x += 40 + text_length(text, 12) + 30;
    }
}

Figure touch_figure(const TouchTrace& trace, const std::string& title, const std::string& note)
{
    const double seconds = seconds_at(trace, trace.ticks.size());
    constexpr std::array<Panel, 3> panels = {
        {{"force, N", force_of, 0, plot_color(0)},
         {"depth, mm", millimetres_of, 0, plot_color(2)},
         {"share of the force given", share_of, 1, plot_color(1)}}};
    Figure whole{.height = 0};
    for (const Panel& panel : panels) {
        double top = panel.top;
        for (const TracedTick& tick : trace.ticks) top = std::max(top, panel.value(tick));
        if (panel.top == 0) top = round_top(top);
        const bool first = whole.height == 0;
        Plot plot(linear_scale(seconds), linear_scale(top),
                  {.title = first ? title : std::string(),
                   .notes = first ? std::vector<std::string>{note} : std::vector<std::string>{},
                   .x = &panel == &panels.back() ? "seconds" : "",
                   .y = panel.axis,
                   .height = panel_height});
        tint_faults(plot, trace, top);
        draw_band(plot, trace);
        draw_curve(plot, trace, panel);
        put_below(whole, std::move(plot.figure));
    }
    draw_keys(whole, whole.height + 10.0);
    whole.height += 40;
    return whole;
}

std::string touch_csv(const TouchTrace& trace)
{
    std::string csv = "seconds,x,y,z,force_x,force_y,force_z,depth,share,hold,condition\n";
    for (std::size_t i = 0; i < trace.ticks.size(); ++i) {
        const TracedTick& tick = trace.ticks[i];
        fmt::format_to(std::back_inserter(csv), "{:.9g},{},{},{},{},{},{},{},{},{},{}\n",
                       seconds_at(trace, i), tick.position.x(), tick.position.y(),
                       tick.position.z(), tick.force.x(), tick.force.y(), tick.force.z(),
                       tick.depth, tick.share, word_of(tick.hold), word_of(tick.condition));
    }
    return csv;
}

} // namespace

TracedTick traced(const HapticRenderer& renderer) noexcept
{
    const SurfaceRenderer& parts = parts_of(renderer);
    const RenderTick& tick = renderer.last();
    return {.position = tick.position,
            .force = tick.force,
            .depth = tick.depth / renderer.map().units_per_metre,
            .share = static_cast<float>(parts.guard().ramp() * parts.passivity().softness()),
            .hold = tick.hold,
            .condition = tick.condition};
}

Status write_touch_plot(const TouchTrace& trace, const std::string& title, const std::string& note,
                        const std::string& path, Progress* progress)
{
    return write_plot([&] { return touch_csv(trace); },
                      [&] { return touch_figure(trace, title, note); }, path, progress);
}

} // namespace proxima
