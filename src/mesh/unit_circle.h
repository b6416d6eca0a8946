// Points of the unit circle with the same bits on every machine: what sample meshes are made of.
//
//     count = 8:   3 2 1        unit_circle(0, count) = (1, 0), counter-clockwise; the eight points
//                  4 . 0        at multiples of 45 degrees and all mirror images are exact mirror
//                  5 6 7        images, those on the axes exactly 0 and +-1 (never -0)
#pragma once

#include <cstdint>

namespace proxima {

struct CirclePoint {
    double cosine = 1.0;
    double sine = 0.0;
};

/// Cosine and sine of 2 pi step / count, rounded to multiples of 2^-40. Integer arithmetic
/// throughout: no mathematical library takes part. Thread safe. \pre count > 0
[[nodiscard]] CirclePoint unit_circle(std::uint32_t step, std::uint32_t count) noexcept;

/// A number of at most 1 in magnitude, rounded to a multiple of 2^-40 like the above. Products that
/// are simple in exact arithmetic become so again: sin 54 cos 72 degrees is 1/4. Ties to even.
[[nodiscard]] double on_circle_grid(double value) noexcept;

} // namespace proxima
