// Numbers in text files, read fast and exactly.
//
// Most coordinates have at most 15 digits and a small exponent. Then both the digits and the power
// of ten are exact doubles, and one multiplication or division rounds once: correct by construction
// [clinger-1990]. The rest goes to from_chars.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace proxima::detail {

/// Reads a real number at `begin`: decimal or scientific, with an optional sign, "nan" and "inf" in
/// any letter case, and the old Windows forms "1.#INF", "-1.#IND", "1.#QNAN". The result is the
/// nearest double; too large is infinity, too small is zero. Returns where the number ends, nullptr
/// where there is none.
[[nodiscard]] const char* parse_real_slowly(const char* begin, const char* end,
                                            double& value) noexcept;

/// Exact powers of ten.
inline constexpr double powers_of_ten[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                           1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                           1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

inline constexpr std::uint64_t whole_powers_of_ten[] = {
    1, 10, 100, 1'000, 10'000, 100'000, 1'000'000, 10'000'000, 100'000'000};

[[nodiscard]] inline bool is_digit(char letter) noexcept
{
    return static_cast<unsigned char>(letter - '0') < 10;
}

/// Moves over digits and appends them to `digits`, whose overflow the caller notices by their
/// number. Eight at a time: how many there are costs no branch.
[[nodiscard]] inline const char* parse_digits(const char* position, const char* end,
                                              std::uint64_t& digits) noexcept
{
    if constexpr (std::endian::native == std::endian::little) {
        while (end - position >= 8) {
            std::uint64_t values = 0; // the first letter in the lowest byte
            std::memcpy(&values, position, sizeof values);
            values ^= 0x3030303030303030U; // digits to 0..9
            const std::uint64_t others =
                ((values + 0x7676767676767676U) | values) & 0x8080808080808080U;
            const auto count = static_cast<unsigned>(std::countr_zero(others)) / 8;
            if (count == 0) return position;
            values <<= 8 * (8 - count);            // as many leading zeros
            values = values * 10 + (values >> 8U); // pairs of digits in every second byte
            const std::uint64_t pairs = 0x000000FF000000FFU;
            const std::uint64_t eight =
                ((values & pairs) * (100 + (std::uint64_t{1'000'000} << 32U)) +
                 (values >> 16U & pairs) * (1 + (std::uint64_t{10'000} << 32U))) >>
                32U;
            digits = digits * whole_powers_of_ten[count] + eight;
            position += count;
            if (count < 8) return position;
        }
    }
    for (; position < end && is_digit(*position); ++position) {
        digits = digits * 10 + static_cast<std::uint64_t>(*position - '0');
    }
    return position;
}

/// parse_real_slowly, fast for short numbers.
[[nodiscard]] inline const char* parse_real(const char* begin, const char* end,
                                            double& value) noexcept
{
    constexpr std::uint64_t exact_limit = std::uint64_t{1} << 53U;
    constexpr int exact_power = 22;
    constexpr std::ptrdiff_t digit_limit = 19;

    const char* position = begin;
    const bool negative = position < end && *position == '-';
    if (negative) ++position;
    std::uint64_t digits = 0;
    const char* const first_digit = position;
    for (; position < end && is_digit(*position); ++position) {
        digits = digits * 10 + static_cast<std::uint64_t>(*position - '0');
    }
    std::ptrdiff_t digit_count = position - first_digit;
    int exponent = 0;
    if (position < end && *position == '.') {
        const char* const first_decimal = ++position;
        position = parse_digits(position, end, digits);
        digit_count += position - first_decimal;
        if (digit_count > digit_limit) return parse_real_slowly(begin, end, value);
        exponent = -static_cast<int>(position - first_decimal);
    }
    if (digit_count == 0 || digit_count > digit_limit || digits > exact_limit) {
        return parse_real_slowly(begin, end, value);
    }
    if (position < end && (*position == 'e' || *position == 'E')) {
        const char* power = position + 1;
        const bool shrinks = power < end && *power == '-';
        if (power < end && (*power == '-' || *power == '+')) ++power;
        const char* const first_power_digit = power;
        int power_value = 0;
        for (; power < end && is_digit(*power) && power - first_power_digit < 4; ++power) {
            power_value = power_value * 10 + (*power - '0');
        }
        const bool more_digits = power < end && is_digit(*power);
        if (power == first_power_digit || more_digits) return parse_real_slowly(begin, end, value);
        exponent += shrinks ? -power_value : power_value;
        position = power;
    } else if (position < end && *position == '#') {
        return parse_real_slowly(begin, end, value);
    }
    if (exponent < -exact_power || exponent > exact_power) {
        return parse_real_slowly(begin, end, value);
    }
    const auto magnitude = static_cast<double>(digits);
    const double scaled =
        exponent < 0 ? magnitude / powers_of_ten[-exponent] : magnitude * powers_of_ten[exponent];
    value = negative ? -scaled : scaled;
    return position;
}

/// Reads a whole number with an optional sign at `begin`. Returns where it ends, nullptr where
/// there is none or it does not fit.
[[nodiscard]] inline const char* parse_integer(const char* begin, const char* end,
                                               std::int64_t& value) noexcept
{
    constexpr std::ptrdiff_t digit_limit = 18; // 10^18 fits
    const char* position = begin;
    const bool negative = position < end && *position == '-';
    if (position < end && (*position == '-' || *position == '+')) ++position;
    const char* const first_digit = position;
    std::int64_t digits = 0;
    for (; position < end && is_digit(*position); ++position) {
        if (position - first_digit >= digit_limit) return nullptr;
        digits = digits * 10 + (*position - '0');
    }
    if (position == first_digit) return nullptr;
    value = negative ? -digits : digits;
    return position;
}

} // namespace proxima::detail
