// Numbers whose size may be beyond that of doubles, as determinants of doubles are.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace proxima {

/// mantissa * 2^exponent.
struct ScaledNumber {
    double mantissa = 0;
    int exponent = 0;
};

/// The numbers in units of one power of two: as they are where no exponent is needed, else the largest
/// is between 1 and 2. What is too small beside it becomes zero.
template <std::size_t Count>
[[nodiscard]] std::array<double, Count>
in_common_units(const std::array<ScaledNumber, Count>& numbers) noexcept
{
    int largest = std::numeric_limits<int>::min();
    bool needs_exponent = false;
    for (const ScaledNumber& number : numbers) {
        if (number.mantissa == 0) continue;
        needs_exponent = needs_exponent || number.exponent != 0;
        largest = std::max(largest, std::ilogb(number.mantissa) + number.exponent);
    }
    std::array<double, Count> values = {};
    for (std::size_t i = 0; i < Count; ++i) {
        const auto& [mantissa, exponent] = numbers[i];
        if (mantissa == 0) continue;
        values[i] = needs_exponent ? std::scalbn(mantissa, exponent - largest) : mantissa;
    }
    return values;
}

} // namespace proxima
