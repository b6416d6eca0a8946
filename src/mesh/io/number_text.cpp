#include "mesh/io/number_text.h"

#include <algorithm>
#include <charconv>
#include <limits>

namespace proxima::detail {

namespace {

bool starts_with_any_case(const char* begin, const char* end, std::string_view word) noexcept
{
    if (end - begin < static_cast<std::ptrdiff_t>(word.size())) return false;
    return std::equal(word.begin(), word.end(), begin, [](char expected, char letter) {
        return expected == (letter >= 'a' && letter <= 'z' ? letter - 'a' + 'A' : letter);
    });
}

// The values of "1.#INF" and similar words, as the C library of old Windows compilers wrote them.
const char* parse_windows_special(const char* begin, const char* end, double& value) noexcept
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const struct {
        std::string_view word;
        double value;
    } specials[] = {{"1.#INF", infinity}, {"1.#QNAN", nan}, {"1.#SNAN", nan}, {"1.#IND", nan}};
    for (const auto& special : specials) {
        if (!starts_with_any_case(begin, end, special.word)) continue;
        const char* position = begin + special.word.size();
        while (position < end && is_digit(*position)) ++position; // "1.#INF00"
        value = special.value;
        return position;
    }
    return nullptr;
}

// Whether a decimal number that does not fit a double is too large rather than too small.
bool is_huge(const char* begin, const char* end) noexcept
{
    const char* exponent_mark =
        std::find_if(begin, end, [](char letter) { return letter == 'e' || letter == 'E'; });
    const char* point = std::find(begin, exponent_mark, '.');
    const char* first_nonzero = std::find_if(
        begin, exponent_mark, [](char letter) { return letter >= '1' && letter <= '9'; });
    // Decimal place of the leading digit: 0.001 has -2, 100 has 3.
    const std::ptrdiff_t leading =
        first_nonzero < point ? point - first_nonzero : point + 1 - first_nonzero;
    if (exponent_mark == end) return leading > 0;
    const char* power = exponent_mark + 1;
    const bool shrinks = power < end && *power == '-';
    if (power < end && (*power == '-' || *power == '+')) ++power;
    std::int64_t power_value = 0;
    for (; power < end && is_digit(*power); ++power) {
        power_value = std::min<std::int64_t>(power_value * 10 + (*power - '0'), 1'000'000'000'000);
    }
    return leading + (shrinks ? -power_value : power_value) > 0;
}

} // namespace

const char* parse_real_slowly(const char* begin, const char* end, double& value) noexcept
{
    const char* position = begin;
    const bool negative = position < end && *position == '-';
    if (position < end && (*position == '-' || *position == '+')) ++position;
    // from_chars would accept a second sign.
    if (position == end || *position == '-' || *position == '+') return nullptr;
    double magnitude = 0;
    const char* stop = parse_windows_special(position, end, magnitude);
    if (stop == nullptr) {
        const auto parsed = std::from_chars(position, end, magnitude);
        if (parsed.ec == std::errc::invalid_argument) return nullptr;
        if (parsed.ec == std::errc::result_out_of_range) {
            magnitude =
                is_huge(position, parsed.ptr) ? std::numeric_limits<double>::infinity() : 0.0;
        }
        stop = parsed.ptr;
    }
    if (stop < end && *stop == '#') return nullptr;
    value = negative ? -magnitude : magnitude;
    return stop;
}

} // namespace proxima::detail
