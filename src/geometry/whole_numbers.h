// Doubles as whole numbers of a grid of their own, so that exact arithmetic on them stays short.
#pragma once

#include "geometry/wide_integer.h"
#include "proxima/geometry.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace proxima::detail {

/// Exponent of the lowest bit that is set. \pre finite, not zero
[[nodiscard]] inline int lowest_bit(double value) noexcept
{
    int exponent = 0;
    const double fraction = std::frexp(std::abs(value), &exponent);
    const auto mantissa = static_cast<std::uint64_t>(std::ldexp(fraction, 53));
    return exponent - 53 + std::countr_zero(mantissa);
}

/// Four numbers times the same power of two, which makes them whole. \pre finite
[[nodiscard]] inline std::array<WideInteger, 4>
whole_numbers(const std::array<double, 4>& values) noexcept
{
    constexpr int own_grid = -1074; // of WideInteger
    int lowest = std::numeric_limits<int>::max();
    for (const double value : values)
        if (value != 0) lowest = std::min(lowest, lowest_bit(value));
    std::array<WideInteger, 4> result;
    for (std::size_t i = 0; i < 4; ++i) {
        // Exact: nothing grows, and every value is a multiple of 2^lowest.
        if (values[i] != 0) result[i] = WideInteger(std::ldexp(values[i], own_grid - lowest));
    }
    return result;
}

/// A point and 1.
[[nodiscard]] inline std::array<WideInteger, 4> whole_numbers(const Vec3& point) noexcept
{
    return whole_numbers(std::array<double, 4>{point.x(), point.y(), point.z(), 1.0});
}

} // namespace proxima::detail
