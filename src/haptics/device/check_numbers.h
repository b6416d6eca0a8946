// The check that options of a device or a renderer are numbers that can be used.
#pragma once

#include "base/text.h"
#include "proxima/result.h"

#include <cmath>
#include <initializer_list>

namespace proxima {

/// An option and its name.
struct NamedNumber {
    const char* name;
    double value;
};

/// Error invalid_argument, naming the first number that is negative or not finite.
[[nodiscard]] inline Status check_not_negative(std::initializer_list<NamedNumber> numbers)
{
    for (const auto& [name, value] : numbers) {
        if (value >= 0 && std::isfinite(value)) continue;
        return fail(ErrorCode::invalid_argument,
                    concat(name, " must be finite and at least 0, not ", value), name);
    }
    return {};
}

/// Like check_not_negative, of a number that must not be 0 either.
[[nodiscard]] inline Status check_positive(const NamedNumber& number)
{
    if (number.value > 0 && std::isfinite(number.value)) return {};
    return fail(ErrorCode::invalid_argument,
                concat(number.name, " must be finite and more than 0, not ", number.value),
                number.name);
}

} // namespace proxima
