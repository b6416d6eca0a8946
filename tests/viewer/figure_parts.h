// What tests look for in a figure: its surfaces by name, its lines and boxes by colour, its pixels.
#pragma once

#include "cli/figure.h"
#include "viewer/figures/thesis_figure.h"
#include "viewer/renderer.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

namespace proxima {

using Pixel = std::array<std::uint8_t, 3>;

inline Pixel pixel_of(unsigned hex)
{
    return {static_cast<std::uint8_t>(hex >> 16U), static_cast<std::uint8_t>(hex >> 8U & 0xFFU),
            static_cast<std::uint8_t>(hex & 0xFFU)};
}

inline const ScenePanel& scene_of(const FigureContent& content, std::size_t panel = 0)
{
    return std::get<ScenePanel>(content.panels.at(panel));
}

inline Image picture_of(const ScenePanel& panel)
{
    return *make_software_renderer()->render(panel.scene, panel.camera, panel.size);
}

inline std::vector<const SceneSurface*> surfaces_named(const DrawnScene& scene,
                                                       const std::string& name)
{
    std::vector<const SceneSurface*> found;
    for (const SceneSurface& surface : scene.surfaces)
        if (surface.name == name) found.push_back(&surface);
    return found;
}

inline std::map<Pixel, int> pixels_by_color(const Image& image)
{
    std::map<Pixel, int> counts;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) ++counts[image.pixel(x, y)];
    return counts;
}

inline std::size_t boxes_of(const Figure& figure, unsigned color)
{
    return static_cast<std::size_t>(std::ranges::count(figure.boxes, color, &FigureBox::color));
}

inline std::size_t lines_of(const Figure& figure, unsigned color, double width)
{
    return static_cast<std::size_t>(
        std::ranges::count_if(figure.lines, [&](const FigureLine& line) {
            return line.color == color && line.width == width;
        }));
}

} // namespace proxima
