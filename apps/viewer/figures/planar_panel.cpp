#include "viewer/figures/planar_panel.h"

#include "viewer/figures/figure_colors.h"

#include <algorithm>
#include <cmath>

namespace proxima {

PlanarBox box_of(const FigureText& text)
{
    const double size = text.style.size;
    const double length = text_length(text.text, size);
    const double before = text.style.anchor == TextAnchor::start    ? 0.0
                          : text.style.anchor == TextAnchor::middle ? 0.5 * length
                                                                    : length;
    return {text.at - Vec2(before, size), text.at + Vec2(length - before, 0.0)};
}

bool crosses(const FigureLine& line, const PlanarBox& box)
{
    // The part of the line within the box, widened by half the line's width, from 0 to 1.
    double enter = 0.0;
    double leave = 1.0;
    for (int axis = 0; axis < 2; ++axis) {
        const double lower = box.min()[axis] - 0.5 * line.width - line.from[axis];
        const double upper = box.max()[axis] + 0.5 * line.width - line.from[axis];
        const double along = line.to[axis] - line.from[axis];
        if (along == 0.0) {
            if (lower > 0.0 || upper < 0.0) return false;
            continue;
        }
        enter = std::max(enter, std::min(lower / along, upper / along));
        leave = std::min(leave, std::max(lower / along, upper / along));
    }
    return enter < leave;
}

PlanarPanel::PlanarPanel(Figure& figure, const PlanarBox& pixels, const PlanarBox& shown)
    : figure_(figure), pixels_(pixels), middle_(shown.center()),
      scale_((pixels.sizes().array() / shown.sizes().array()).minCoeff())
{}

Vec2 PlanarPanel::pixel(const Vec2& point) const
{
    const Vec2 offset = scale_ * (point - middle_);
    return pixels_.center() + Vec2(offset.x(), -offset.y());
}

void PlanarPanel::fill(std::span<const Vec2> corners, unsigned color)
{
    FigurePolygon polygon{{}, color};
    for (const Vec2& corner : corners) polygon.corners.push_back(pixel(corner));
    figure_.polygons.push_back(std::move(polygon));
}

void PlanarPanel::fill_square(const Vec2& center, double half, unsigned color)
{
    figure_.boxes.push_back(
        {pixel(center + Vec2(-half, half)), pixel(center + Vec2(half, -half)), color});
}

void PlanarPanel::square(const Vec2& center, double half, unsigned color, double width)
{
    const std::array<Vec2, 4> corners = {center + Vec2(-half, -half), center + Vec2(half, -half),
                                         center + Vec2(half, half), center + Vec2(-half, half)};
    outline(corners, color, width);
}

void PlanarPanel::outline(std::span<const Vec2> corners, unsigned color, double width)
{
    for (std::size_t i = 0; i < corners.size(); ++i)
        line(corners[i], corners[(i + 1) % corners.size()], color, width);
}

void PlanarPanel::line(const Vec2& from, const Vec2& to, unsigned color, double width)
{
    figure_.lines.push_back({pixel(from), pixel(to), color, width});
}

void PlanarPanel::dashes(const Vec2& from, const Vec2& to, unsigned color, double width)
{
    constexpr double dash = 9.0; // pixels, and as much between two
    const double length = scale_ * (to - from).norm();
    const int count = std::max(1, static_cast<int>(length / (2.0 * dash)));
    for (int i = 0; i <= count; ++i) {
        const double start = std::min(1.0, 2.0 * dash * i / length);
        const double end = std::min(1.0, (2.0 * i + 1.0) * dash / length);
        const Vec2 first = from + start * (to - from);
        const Vec2 last = from + end * (to - from);
        const Vec2 middle = 0.5 * (first + last);
        if (has_words_at(pixel(first)) || has_words_at(pixel(middle)) || has_words_at(pixel(last)))
            continue;
        line(first, last, color, width);
    }
}

bool PlanarPanel::has_words_at(const Vec2& pixel) const
{
    constexpr double margin = 2.0; // pixels
    return std::ranges::any_of(figure_.texts, [&](const FigureText& text) {
        PlanarBox box = box_of(text);
        box.extend(box.min() - Vec2::Constant(margin)).extend(box.max() + Vec2::Constant(margin));
        return box.contains(pixel);
    });
}

bool PlanarPanel::has_space(const Vec2& at, const std::string& text, const Vec2& offset,
                            double size, double clear) const
{
    PlanarBox box = box_of({baseline(at, offset, size), text, {size, 0, TextAnchor::middle}});
    box.extend(box.min() - Vec2::Constant(clear)).extend(box.max() + Vec2::Constant(clear));
    return std::ranges::none_of(figure_.lines,
                                [&](const FigureLine& line) { return crosses(line, box); }) &&
           std::ranges::none_of(figure_.texts, [&](const FigureText& other) {
               return box.intersects(box_of(other));
           });
}

Vec2 PlanarPanel::baseline(const Vec2& at, const Vec2& offset, double size) const
{
    return pixel(at) + Vec2(offset.x(), 0.5 * size - offset.y());
}

void PlanarPanel::arrow(const Vec2& from, const Vec2& to, unsigned color, double width)
{
    line(from, to, color, width);
    const Vec2 along = (to - from).normalized();
    const Vec2 across(-along.y(), along.x());
    const double head = (6.0 + 2.5 * width) / scale_;
    for (const double side : {-0.45, 0.45})
        line(to, to - head * (along + side * across), color, width);
}

void PlanarPanel::dot(const Vec2& at, double diameter_pixels, unsigned color)
{
    line(at, at, color, diameter_pixels);
}

void PlanarPanel::words(const Vec2& at, const std::string& text, const Vec2& offset, double size,
                        unsigned color)
{
    figure_.texts.push_back({baseline(at, offset, size), text, {size, color, TextAnchor::middle}});
}

void PlanarPanel::title(const std::string& text, double size)
{
    figure_.texts.push_back({{pixels_.center().x(), pixels_.min().y() - 12.0},
                             text,
                             {size, figure_colors::ink, TextAnchor::middle}});
}

} // namespace proxima
