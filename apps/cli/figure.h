// A flat drawing of boxes, polygons, lines and text, drawn by cairo and Pango: as PNG, SVG or PDF, or
// over a picture. These are in a library that the first call opens (figure_library.h); where it is missing, all
// functions but check_drawing throw std::runtime_error.
//
//     Figure figure{.width = 1200, .height = 800};
//     figure.lines.push_back({{60, 700}, {1180, 700}, 0x333333, 2});
//     write_figure(figure, "plot.svg");
#pragma once

#include "cli/image.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <string>
#include <string_view>
#include <vector>

namespace proxima {

enum class TextAnchor { start, middle, end };
enum class TextTurn { level, upward };

struct TextStyle {
    double size = 16.0; ///< height of capitals in pixels
    unsigned color = 0; ///< 0xRRGGBB
    TextAnchor anchor = TextAnchor::start;
    TextTurn turn = TextTurn::level; ///< upward: read from below to above
};

/// Whether the library that draws is there, for commands to ask before long work. Errors: file_not_found, unsupported_format.
[[nodiscard]] Status check_drawing();

/// How long one line of this text is, in pixels, for capitals of this height.
[[nodiscard]] double text_length(std::string_view text, double size);

struct FigureBox {
    Vec2 lower = Vec2::Zero();
    Vec2 upper = Vec2::Zero();
    unsigned color = 0; ///< 0xRRGGBB, as all colours here
    double opacity = 1.0;
};

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

/// One line of text in any script. Bytes that are no UTF-8 are question marks.
struct FigureText {
    Vec2 at = Vec2::Zero(); ///< the anchor, on the baseline
    std::string text;
    TextStyle style = {};
};

/// In pixels from the upper left corner: boxes below polygons below lines below text.
struct Figure {
    int width = 1200;
    int height = 800;
    std::vector<FigureBox> boxes = {};
    std::vector<FigurePolygon> polygons = {};
    std::vector<FigureLine> lines = {};
    std::vector<FigureText> texts = {};
};

/// On white.
[[nodiscard]] Image figure_image(const Figure& figure);

/// Draws the figure over a picture, its upper left corner at (left, top); what is beside the
/// picture is cut off.
void draw_over(Image& image, const Figure& figure, int left, int top);

/// By extension, .png, .svg or .pdf, on white, whole or not at all. In .svg letters are outlines.
/// Errors: unsupported_format, file_not_writable, cancelled.
[[nodiscard]] Status write_figure(const Figure& figure, const std::string& path,
                                  Progress* progress = nullptr);

} // namespace proxima
