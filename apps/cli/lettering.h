// Letters made of strokes, so that pictures can be labelled without a font.
#pragma once

#include "cli/canvas.h"
#include "proxima/geometry.h"

#include <array>
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

/// How long the text is, in pixels, for capitals of this height. Bytes that are no printable ASCII
/// count as boxes.
[[nodiscard]] double text_length(std::string_view text, double size) noexcept;

/// The strokes of one line of text whose anchor stands on the baseline at (x, y) pixels.
[[nodiscard]] std::vector<std::array<Vec2, 2>> text_strokes(std::string_view text, double x,
                                                            double y, const TextStyle& style);

/// How wide the strokes are, in pixels.
[[nodiscard]] double stroke_width(const TextStyle& style) noexcept;

/// Draws one line of text; its anchor stands on the baseline at (x, y) pixels. Above all else.
void draw_text(Canvas& canvas, std::string_view text, double x, double y, const TextStyle& style);

} // namespace proxima
