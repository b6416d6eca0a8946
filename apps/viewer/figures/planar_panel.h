// A part of a flat drawing with coordinates of its own: y points up.
#pragma once

#include "cli/figure.h"
#include "proxima/geometry.h"

#include <span>
#include <string>

namespace proxima {

using PlanarBox = Eigen::AlignedBox2d;

/// Where words stand, in pixels of the figure: from their baseline up to their size.
[[nodiscard]] PlanarBox box_of(const FigureText& text);
/// Whether a line with its width goes through a part of the figure.
[[nodiscard]] bool crosses(const FigureLine& line, const PlanarBox& box);

class PlanarPanel {
public:
    /// Shows `shown` as large as fits the pixels, in their middle. \pre figure outlives the panel
    PlanarPanel(Figure& figure, const PlanarBox& pixels, const PlanarBox& shown);

    [[nodiscard]] Vec2 pixel(const Vec2& point) const;
    [[nodiscard]] double scale() const noexcept { return scale_; } ///< pixels per unit

    void fill(std::span<const Vec2> corners, unsigned color);
    void fill_square(const Vec2& center, double half, unsigned color);
    void square(const Vec2& center, double half, unsigned color, double width);
    void outline(std::span<const Vec2> corners, unsigned color, double width);
    void line(const Vec2& from, const Vec2& to, unsigned color, double width);
    /// A dashed line, interrupted where there is text already.
    void dashes(const Vec2& from, const Vec2& to, unsigned color, double width);
    /// A line with a head at its end.
    void arrow(const Vec2& from, const Vec2& to, unsigned color, double width);
    void dot(const Vec2& at, double diameter_pixels, unsigned color);
    /// Words whose middle stands `offset` pixels (right, up) from a point.
    void words(const Vec2& at, const std::string& text, const Vec2& offset, double size,
               unsigned color);
    /// Whether they would stand so many pixels clear of all lines and words that were drawn.
    [[nodiscard]] bool has_space(const Vec2& at, const std::string& text, const Vec2& offset,
                                 double size, double clear) const;
    /// Above the panel's pixels.
    void title(const std::string& text, double size = 17.0);

private:
    [[nodiscard]] bool has_words_at(const Vec2& pixel) const;
    [[nodiscard]] Vec2 baseline(const Vec2& at, const Vec2& offset, double size) const;

    Figure& figure_;
    PlanarBox pixels_;
    Vec2 middle_;
    double scale_;
};

} // namespace proxima
