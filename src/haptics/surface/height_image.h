// Height images of textures (HeightImage in touch_scene.h): a uniform cubic B-spline whose control
// points are the samples, tiled.
//
//     g(c, r) = sum of samples[j][i] B(c - i) B(r - j)     c, r by pixels, at whole numbers in their middles
//
// It is twice continuously differentiable, and nowhere above or below its samples. It does not pass
// through them: of a wave n pixels long the part 1 - (1 - cos(2 pi / n)) / 3 is left.
#pragma once

#include "proxima/geometry.h"
#include "proxima/touch_scene.h"

#include <cstddef>
#include <vector>

namespace proxima {

/// The samples, and bounds of the slope and the curvature of h = 2 g - 1 where a picture is one wide.
class PROXIMA_HIDDEN HeightSamples {
public:
    /// O(samples). \pre a multiple of `columns`, not zero, of numbers from 0 to 1
    HeightSamples(std::vector<float> samples, std::size_t columns);

    [[nodiscard]] std::size_t columns() const noexcept { return columns_; }
    [[nodiscard]] std::size_t rows() const noexcept { return rows_; }
    [[nodiscard]] const std::vector<float>& samples() const noexcept { return samples_; }
    [[nodiscard]] double slope() const noexcept { return slope_; }
    [[nodiscard]] double curvature() const noexcept { return curvature_; }

private:
    std::vector<float> samples_;
    std::size_t columns_;
    std::size_t rows_;
    double slope_ = 0;
    double curvature_ = 0;
};

/// The height of an image and its derivatives by `right` and `up`.
struct ImageHeight {
    double value = 1; ///< h
    double right = 0;
    double up = 0;
};

/// At a position in widths of the picture, right of and above the lower left corner of a tile.
/// noexcept, O(1). \pre finite
[[nodiscard]] ImageHeight height_at(const HeightSamples& image, double right, double up) noexcept;

/// The directions of an image that is projected along a third one, of length 1.
struct ImageAxes {
    Vec3 right;
    Vec3 up;
};

/// \pre the direction is not zero
[[nodiscard]] ImageAxes image_axes(const Vec3& direction) noexcept;

} // namespace proxima
