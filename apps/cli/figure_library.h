// The library that draws figures for the program, which is opened when the first one is drawn: cairo, Pango and what they
// need take longer to load than most commands take.
#pragma once

#include "cli/figure.h"

#include <string>
#include <string_view>

namespace proxima {

/// What the library does.
struct FigureDrawing {
    /// As the functions of figure.h.
    double (*text_length)(std::string_view text, double size);
    void (*draw_over)(Image& image, const Figure& figure, int left, int top);
    /// A file of .pdf or else .svg, on white.
    std::string (*document)(const Figure& figure, bool is_pdf);
};

/// What the library exports.
using GetFigureDrawing = const FigureDrawing*() noexcept;

inline constexpr const char* figure_drawing_name = "proxima_figure_drawing";

} // namespace proxima
