// Sine, cosine and decay of textures, by polynomials of the library's own: those of the C library have
// other last bits on processors with fused multiply-add, and recordings are replayed bit for bit.
#pragma once

#include <cmath>
#include <initializer_list>
#include <numbers>

namespace proxima {

struct Wave {
    double sine = 0;
    double cosine = 1;
};

/// Sine and cosine of 2 pi `turns`, to 4e-16 of a turn that is counted exactly. \pre |turns| < 2^52
[[nodiscard]] inline Wave wave_at(double turns) noexcept
{
    const double quarters = 4 * (turns - std::floor(turns));
    const double nearest = std::floor(quarters + 0.5);
    const double x = (quarters - nearest) * (std::numbers::pi / 2);
    const double y = x * x;
    // Taylor's series up to x^15 and x^16, for |x| <= pi / 4.
    double sine = -1.0 / 1307674368000;
    for (const double term :
         {1.0 / 6227020800, -1.0 / 39916800, 1.0 / 362880, -1.0 / 5040, 1.0 / 120, -1.0 / 6, 1.0})
        sine = sine * y + term;
    sine *= x;
    double cosine = 1.0 / 20922789888000;
    for (const double term : {-1.0 / 87178291200, 1.0 / 479001600, -1.0 / 3628800, 1.0 / 40320,
                              -1.0 / 720, 1.0 / 24, -1.0 / 2, 1.0})
        cosine = cosine * y + term;
    switch (static_cast<int>(nearest) % 4) {
    case 1:
        return {cosine, -sine};
    case 2:
        return {-sine, -cosine};
    case 3:
        return {-cosine, sine};
    default:
        return {sine, cosine};
    }
}

/// e^-x, to 1e-12 of it. \pre 0 <= x <= 64
[[nodiscard]] inline double decay_of(double x) noexcept
{
    // Taylor's series of e^(x / 1024), whose reciprocal is squared ten times.
    const double y = x / 1024;
    double rise = 1;
    for (const double n : {8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0}) rise = 1 + rise * y / n;
    double fall = 1 / rise;
    for (int i = 0; i < 10; ++i) fall *= fall;
    return fall;
}

} // namespace proxima
