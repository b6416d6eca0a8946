#include "cli/lettering.h"

#include <algorithm>
#include <array>

namespace proxima {
namespace {

// A glyph is polylines, divided by spaces. A point is a digit, x from 0 to 8, and a letter, y from
// -4 (a) by 0 on the baseline (e) and 8, the height of small letters (m), to 12, that of capitals
// (q).
constexpr int baseline = 'e';
constexpr double capital = 12.0;
constexpr double gap = 3.0;   // between letters
constexpr double blank = 4.0; // the width of a space
constexpr char first_printable = ' ';

constexpr std::array<std::string_view, 95> glyphs = {
    "",                                 // space
    "1q1i 1e1f",                        // !
    "0q0n 3q3n",                        // "
    "2e3q 5e6q 0i8i 0n8n",              // #
    "8o6q2q0o0m2k6k8i8g6e2e0g 4r4d",    // $
    "0e8q 1m3m3p1p1m 5e7e7h5h5e",       // %
    "8e1n1p2q4q5p5n0i0g2e5e8i",         // &
    "1q1n",                             // '
    "3q1n0k0g1d3b",                     // (
    "0q2n3k3g2d0b",                     // )
    "3o3i 0m6j 6m0j",                   // *
    "0i6i 3f3l",                        // +
    "1f0c",                             // ,
    "0i5i",                             // -
    "1e1f",                             // .
    "0d5q",                             // /
    "2e6e8g8o6q2q0o0g2e",               // 0
    "1n4q4e 1e7e",                      // 1
    "0o2q6q8o8l0e8e",                   // 2
    "0o2q6q8o8m6k8i8g6e2e0g 3k6k",      // 3
    "6e6q0h8h",                         // 4
    "8q1q1k6k8i8g6e2e0g",               // 5
    "7q4q0l0g2e6e8g8i6k2k0i",           // 6
    "0q8q3e",                           // 7
    "2k0m0o2q6q8o8m6k2k0i0g2e6e8g8i6k", // 8
    "1e4e8j8o6q2q0o0m2k6k8m",           // 9
    "1e1f 1k1l",                        // :
    "1k1l 1f0c",                        // ;
    "6m0i6e",                           // <
    "0g6g 0k6k",                        // =
    "0m6i0e",                           // >
    "0o2q5q7o7m4j4h 4e4f",              // ?
    "6g6l3l2k2h3g6g8h8o6q2q0o0g2e6e",   // @
    "0e4q8e 1i7i",                      // A
    "0e0q6q8o8m6k0k 6k8i8g6e0e",        // B
    "8o6q2q0o0g2e6e8g",                 // C
    "0e0q5q8n8h5e0e",                   // D
    "8q0q0e8e 0k6k",                    // E
    "8q0q0e 0k6k",                      // F
    "8o6q2q0o0g2e6e8g8k5k",             // G
    "0e0q 8e8q 0k8k",                   // H
    "0q4q 2q2e 0e4e",                   // I
    "6q6g4e2e0g",                       // J
    "0q0e 8q0i 3k8e",                   // K
    "0q0e7e",                           // L
    "0e0q4j8q8e",                       // M
    "0e0q8e8q",                         // N
    "2e6e8g8o6q2q0o0g2e",               // O
    "0e0q6q8o8l6j0j",                   // P
    "2e6e8g8o6q2q0o0g2e 5h8e",          // Q
    "0e0q6q8o8l6j0j 4j8e",              // R
    "8o6q2q0o0m2k6k8i8g6e2e0g",         // S
    "0q8q 4q4e",                        // T
    "0q0g2e6e8g8q",                     // U
    "0q4e8q",                           // V
    "0q2e4m6e8q",                       // W
    "0q8e 8q0e",                        // X
    "0q4k8q 4k4e",                      // Y
    "0q8q0e8e",                         // Z
    "3q0q0b3b",                         // [
    "0q5d",                             // backslash
    "0q3q3b0b",                         // ]
    "0n3q6n",                           // ^
    "0c7c",                             // _
    "0q2n",                             // `
    "0l2m5m7k7e 7i2i0h0f2e5e7g",        // a
    "0q0e 0k2m5m7k7g5e2e0g",            // b
    "7l5m2m0k0g2e5e7f",                 // c
    "7q7e 7k5m2m0k0g2e5e7g",            // d
    "0i7i7k5m2m0k0g2e5e7f",             // e
    "6q4q2o2e 0m5m",                    // f
    "7m7b5a1a 7k5m2m0k0g2e5e7g",        // g
    "0q0e 0k2m5m7k7e",                  // h
    "1m1e 1p1q",                        // i
    "2m2b1a0a 2p2q",                    // j
    "0q0e 6m0h 2i6e",                   // k
    "1q1e",                             // l
    "0e0m 0k1m3m4k4e 4k5m7m8k8e",       // m
    "0e0m 0k2m5m7k7e",                  // n
    "2e5e7g7k5m2m0k0g2e",               // o
    "0m0a 0k2m5m7k7g5e2e0g",            // p
    "7m7a 7k5m2m0k0g2e5e7g",            // q
    "0e0m 0j2m4m5l",                    // r
    "6l5m1m0l0j1i5i6h6f5e1e0f",         // s
    "2q2g3e5e 0m5m",                    // t
    "0m0g2e5e7g 7m7e",                  // u
    "0m3e6m",                           // v
    "0m2e4k6e8m",                       // w
    "0m6e 6m0e",                        // x
    "0m3e 6m1a0a",                      // y
    "0m6m0e6e",                         // z
    "3q2q1o1l0j1h1d2b3b",               // {
    "1q1b",                             // |
    "0q1q2o2l3j2h2d1b0b",               // }
    "0i1k3k5i7i8k",                     // ~
};
constexpr std::string_view unknown_glyph = "0e0q6q6e0e";

std::string_view glyph_of(char letter) noexcept
{
    const int position = letter - first_printable;
    if (position < 0 || position >= static_cast<int>(glyphs.size())) return unknown_glyph;
    return glyphs[static_cast<std::size_t>(position)];
}

double width_of(char letter) noexcept
{
    if (letter == ' ') return blank;
    double width = 0;
    for (const char sign : glyph_of(letter))
        if (sign >= '0' && sign <= '8') width = std::max(width, 1.0 * (sign - '0'));
    return width;
}

} // namespace

double text_length(std::string_view text, double size) noexcept
{
    double length = 0;
    for (const char letter : text) length += width_of(letter) + gap;
    return text.empty() ? 0.0 : (length - gap) * size / capital;
}

std::vector<std::array<Vec2, 2>> text_strokes(std::string_view text, double x, double y,
                                              const TextStyle& style)
{
    const double scale = style.size / capital;
    const double length = text_length(text, style.size);
    double pen = style.anchor == TextAnchor::start    ? 0.0
                 : style.anchor == TextAnchor::middle ? -0.5 * length
                                                      : -length;
    const auto position = [&](char across, char up) -> Vec2 {
        const double along = pen + scale * (across - '0');
        const double above = scale * (up - baseline);
        if (style.turn == TextTurn::upward) return {x - above, y - along};
        return {x + along, y - above};
    };
    std::vector<std::array<Vec2, 2>> lines;
    for (const char letter : text) {
        const std::string_view strokes = glyph_of(letter);
        for (std::size_t i = 0; i + 3 < strokes.size(); i += 2) {
            if (strokes[i + 2] == ' ') { // the next polyline
                --i;
                i += 2;
                continue;
            }
            lines.push_back(
                {position(strokes[i], strokes[i + 1]), position(strokes[i + 2], strokes[i + 3])});
        }
        pen += scale * (width_of(letter) + gap);
    }
    return lines;
}

double stroke_width(const TextStyle& style) noexcept
{
    return std::max(1.0, 0.11 * style.size);
}

void draw_text(Canvas& canvas, std::string_view text, double x, double y, const TextStyle& style)
{
    constexpr double nearest = 1e6;
    const Color color = srgb(style.color);
    const LineStyle line = {.width = stroke_width(style)};
    for (const auto& [from, to] : text_strokes(text, x, y, style))
        canvas.draw_line({from.x(), from.y(), nearest}, {to.x(), to.y(), nearest}, color, line);
}

} // namespace proxima
