// A small software renderer: triangles with a depth buffer, then lines over them, averaged down.
//
//     Canvas canvas(1600, 1200, {top, bottom});
//     canvas.draw_triangle({a, b, c});       // vertices as Camera::project gives them, with colour
//     canvas.draw_line(a, b, color, style);
//     const Image image = canvas.image();
#pragma once

#include "base/progress.h"
#include "cli/image.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace proxima {

/// Linear light, each channel 0 to 1.
using Color = Eigen::Array3f;

/// A colour by its sRGB bytes, 0xRRGGBB.
[[nodiscard]] Color srgb(unsigned hex);

/// The nearest colour in sRGB bytes, 0xRRGGBB.
[[nodiscard]] unsigned hex_of(const Color& color);

/// A point on the screen: pixels from the upper left corner, and nearness 1 / distance along the
/// view axis, which is linear on the screen.
struct ScreenPoint {
    double x = 0.0;
    double y = 0.0;
    double nearness = 0.0;
};

struct ScreenVertex {
    ScreenPoint point;
    Color color = Color::Zero();
};

struct LineStyle {
    double width = 1.0; ///< pixels
    float opacity = 1.0F;
    double lift = 0.0; ///< part of the distance by which it is drawn nearer
};

/// A vertical gradient.
struct Background {
    Color top = Color::Ones();
    Color bottom = Color::Ones();
};

class Canvas {
public:
    /// Once `progress`, where given, is cancelled, nothing more is drawn: what there is then is no
    /// picture. \pre both positive
    Canvas(int width, int height, const Background& background = {},
           const Progress* progress = nullptr);

    /// Fills the triangle where nothing drawn before is nearer. Parts outside the canvas are cut.
    /// Returns how many samples it looked at. \pre all three in front of the eye
    std::uint64_t draw_triangle(const std::array<ScreenVertex, 3>& triangle);

    /// Blends the triangle, of one colour, over what lies there, where nothing is nearer: later
    /// triangles are not hidden by it, so far ones are to be drawn first.
    /// \pre all three in front of the eye
    void blend_triangle(const std::array<ScreenPoint, 3>& triangle, const Color& color,
                        float opacity);

    /// Hides lines behind the triangle without drawing it: a pane of glass that only lines heed.
    void hide_lines_behind(const std::array<ScreenPoint, 3>& triangle);

    /// Blends a line over what lies there, where no triangle or pane is nearer.
    void draw_line(const ScreenPoint& from, const ScreenPoint& to, const Color& color,
                   const LineStyle& style);

    /// Darkens creases and places near other surfaces: ambient light that neighbours of up to
    /// `radius` pixels keep away. To be called after the triangles, before the lines.
    void darken_creases(double radius, float strength);

    /// The picture so far.
    [[nodiscard]] Image image() const;

private:
    void fill(const Background& background);

    /// Calls put(sample, nearness, u, v, w) for all samples that the triangle covers. Returns how many
    /// it looked at.
    template <class Put>
    std::uint64_t cover(const std::array<ScreenPoint, 3>& triangle, const Put& put) const;

    [[nodiscard]] std::size_t sample_index(int x, int y) const noexcept
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(x);
    }

    [[nodiscard]] bool stopped() const noexcept { return is_cancelled(progress_); }

    const Progress* progress_;
    int width_;
    int height_;
    int columns_; // samples across
    int rows_;    // samples down
    std::size_t samples_;
    // Written row by row: to touch all of a large picture takes seconds.
    std::unique_ptr<Color[]> colors_;
    std::unique_ptr<float[]> nearness_;      // of triangles drawn, 0 = background
    std::unique_ptr<float[]> line_nearness_; // of panes
};

/// A canvas that, with the picture made of it, fits the budget: about 100 bytes a pixel. Error:
/// budget_exceeded.
[[nodiscard]] Result<Canvas> make_canvas(int width, int height, const Background& background = {},
                                         const Progress* progress = nullptr,
                                         MemoryBudget budget = {});

} // namespace proxima
