#include "cli/legend.h"

#include "cli/figure.h"

#include <algorithm>
#include <cmath>

namespace proxima {

void draw_legend(Image& image, const Legend& legend)
{
    if (legend.entries.empty()) return;
    const double size = std::clamp(image.height / 75.0, 7.0, 12.0);
    const TextStyle style = {.size = size, .color = 0x222222};
    const double line = 2.2 * size;
    double widest = text_length(legend.title, size);
    for (const LegendEntry& entry : legend.entries)
        widest = std::max(widest, 2 * size + text_length(entry.text, size));
    const std::size_t lines = legend.entries.size() + (legend.title.empty() ? 0 : 1);
    Figure box{.width = static_cast<int>(std::ceil(widest + 2 * size)),
               .height = static_cast<int>(std::ceil(static_cast<double>(lines) * line + size))};
    if (2 * box.width > image.width || 2 * box.height > image.height) return;
    box.boxes.push_back({Vec2::Zero(), Vec2(box.width, box.height), 0xFFFFFF, 0.82});
    double middle = 0.5 * (size + line);
    const auto write = [&](double x, const std::string& text) {
        box.texts.push_back({{x, middle + 0.5 * size}, text, style});
        middle += line;
    };
    if (!legend.title.empty()) write(size, legend.title);
    for (const LegendEntry& entry : legend.entries) {
        const Vec2 corner(size, middle - 0.5 * size);
        box.boxes.push_back({corner, corner + Vec2::Constant(size), entry.color});
        write(3 * size, entry.text);
    }
    const int space = static_cast<int>(std::lround(size));
    draw_over(image, box, image.width - box.width - space, space);
}

} // namespace proxima
