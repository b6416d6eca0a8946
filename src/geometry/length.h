// The length and the direction of a vector, also where the squares of its coordinates leave the
// doubles.
#pragma once

#include "proxima/geometry.h"

#include <algorithm>
#include <cmath>

namespace proxima {

/// The length has the same bits on every processor, and at every address of the vector. Eigen's
/// stableNorm() does not promise that. It is infinite or NaN where a coordinate is.
[[nodiscard]] inline double length_of(const Vec3& v) noexcept
{
    const auto squared = [](double x, double y, double z) { return (x * x + y * y) + z * z; };
    const double direct = squared(v.x(), v.y(), v.z());
    if ((direct > 0x1p-900 && direct < 0x1p+900) || std::isnan(direct)) return std::sqrt(direct);
    const double largest = std::max({std::abs(v.x()), std::abs(v.y()), std::abs(v.z())});
    if (!(largest > 0) || std::isinf(largest)) return largest;
    const double scale = std::ldexp(1.0, -std::clamp(std::ilogb(largest), -1000, 1000));
    return std::sqrt(squared(v.x() * scale, v.y() * scale, v.z() * scale)) / scale;
}

/// The vector of length 1 along v: of every finite v but zero, which stays what it is. Eigen's stableNormalized()
/// is of another length where doubles lose digits, and zero where they overflow.
[[nodiscard]] inline Vec3 unit_of(const Vec3& v) noexcept
{
    const double largest = v.cwiseAbs().maxCoeff();
    if ((largest > 0x1p-900 && largest < 0x1p+900) || !(largest > 0) || !std::isfinite(largest))
        return v.stableNormalized();
    const int exponent = -std::ilogb(largest);
    return Vec3(std::scalbn(v.x(), exponent), std::scalbn(v.y(), exponent),
                std::scalbn(v.z(), exponent))
        .stableNormalized();
}

} // namespace proxima
