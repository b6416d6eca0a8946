#include "cli/legend.h"

#include "cli/lettering.h"

#include <algorithm>
#include <cmath>

namespace proxima {
namespace {

/// Lays a colour over a pixel; nothing beside the picture.
void blend(Image& image, int x, int y, unsigned color, double opacity)
{
    if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
    const std::size_t first =
        3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
             static_cast<std::size_t>(x));
    for (std::size_t channel = 0; channel < 3; ++channel) {
        const double wanted = (color >> (16U - 8U * channel)) & 0xFFU;
        std::uint8_t& byte = image.bytes[first + channel];
        byte = static_cast<std::uint8_t>(std::lround(byte + opacity * (wanted - byte)));
    }
}

struct Rectangle {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;
};

void fill(Image& image, const Rectangle& area, unsigned color, double opacity)
{
    for (int y = area.y; y < area.y + area.height; ++y)
        for (int x = area.x; x < area.x + area.width; ++x) blend(image, x, y, color, opacity);
}

double distance_to(const std::array<Vec2, 2>& stroke, const Vec2& point)
{
    const Vec2 along = stroke[1] - stroke[0];
    const double length = along.squaredNorm();
    const double part =
        length > 0.0 ? std::clamp((point - stroke[0]).dot(along) / length, 0.0, 1.0) : 0.0;
    return (stroke[0] + part * along - point).norm();
}

/// Pixels as far as they are covered by the nearest stroke.
void write(Image& image, std::string_view text, double x, double y, const TextStyle& style)
{
    const auto strokes = text_strokes(text, x, y, style);
    const double half = 0.5 * stroke_width(style);
    const Rectangle area = {static_cast<int>(x) - 2, static_cast<int>(y - 1.5 * style.size),
                            static_cast<int>(text_length(text, style.size)) + 5,
                            static_cast<int>(2.2 * style.size)};
    for (int row = area.y; row < area.y + area.height; ++row) {
        for (int column = area.x; column < area.x + area.width; ++column) {
            double nearest = 2.0 * style.size;
            for (const auto& stroke : strokes)
                nearest = std::min(nearest, distance_to(stroke, {column + 0.5, row + 0.5}));
            blend(image, column, row, style.color, std::clamp(half + 0.5 - nearest, 0.0, 1.0));
        }
    }
}

} // namespace

void draw_legend(Image& image, const Legend& legend)
{
    if (legend.entries.empty()) return;
    const double size = std::clamp(image.height / 65.0, 7.0, 14.0);
    const TextStyle style = {.size = size, .color = 0x222222};
    const int line = static_cast<int>(std::lround(2.0 * size));
    const int space = static_cast<int>(std::lround(size));
    double widest = text_length(legend.title, size);
    for (const LegendEntry& entry : legend.entries)
        widest = std::max(widest, 2 * space + text_length(entry.text, size));
    const int lines = static_cast<int>(legend.entries.size()) + (legend.title.empty() ? 0 : 1);
    const int width = static_cast<int>(std::ceil(widest)) + 2 * space;
    const Rectangle box = {image.width - width - space, space, width, lines * line + space};
    fill(image, box, 0xFFFFFF, 0.82);
    const int left = box.x + space;
    int middle = box.y + space / 2 + line / 2;
    if (!legend.title.empty()) {
        write(image, legend.title, left, middle + 0.5 * size, style);
        middle += line;
    }
    for (const LegendEntry& entry : legend.entries) {
        fill(image, {left, middle - space / 2, space, space}, entry.color, 1.0);
        write(image, entry.text, left + 2 * space, middle + 0.5 * size, style);
        middle += line;
    }
}

} // namespace proxima
