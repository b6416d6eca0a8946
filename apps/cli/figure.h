// A flat drawing of boxes, polygons, lines and text, written as SVG or drawn as a picture.
//
//     Figure figure{.width = 1200, .height = 800};
//     figure.lines.push_back({{60, 700}, {1180, 700}, 0x333333, 2});
//     write_figure(figure, "plot.svg");
#pragma once

#include "cli/image.h"
#include "cli/lettering.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <string>
#include <vector>

namespace proxima {

struct FigureBox {
    Vec2 lower = Vec2::Zero();
    Vec2 upper = Vec2::Zero();
    unsigned color = 0; ///< 0xRRGGBB, as all colours here
};

/// Convex, its corners in either direction.
struct FigurePolygon {
    std::vector<Vec2> corners;
    unsigned color = 0;
};

struct FigureLine {
    Vec2 from = Vec2::Zero();
    Vec2 to = Vec2::Zero();
    unsigned color = 0;
    double width = 1.0;
};

struct FigureText {
    Vec2 at = Vec2::Zero(); ///< the anchor, on the baseline
    std::string text;
    TextStyle style = {};
};

/// In pixels from the upper left corner, on white: boxes below polygons below lines below
/// text.
struct Figure {
    int width = 1200;
    int height = 800;
    std::vector<FigureBox> boxes = {};
    std::vector<FigurePolygon> polygons = {};
    std::vector<FigureLine> lines = {};
    std::vector<FigureText> texts = {};
};

[[nodiscard]] std::string figure_svg(const Figure& figure);
[[nodiscard]] Image figure_image(const Figure& figure);

/// By extension, .svg or .png, whole or not at all. Errors: unsupported_format, file_not_writable,
/// cancelled.
[[nodiscard]] Status write_figure(const Figure& figure, const std::string& path,
                                  Progress* progress = nullptr);

} // namespace proxima
