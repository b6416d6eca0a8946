// Preconditions: a broken one is a bug of the caller and ends the program with both operands shown.
//
//     PROXIMA_CHECK(!stack.empty());
//     PROXIMA_CHECK_LT(index, size);   // prints: check failed: index < size (12 against 8)
//
// They stay on in release builds, so they belong outside inner loops.
#pragma once

#include "base/text.h"

#include <string>

namespace proxima::detail {

/// Prints the message with its file and line to stderr and aborts.
[[noreturn]] void check_failed(const char* file, int line, const std::string& message) noexcept;

} // namespace proxima::detail

#define PROXIMA_CHECK(condition)                                                                   \
    do {                                                                                           \
        if (!(condition)) [[unlikely]] {                                                           \
            ::proxima::detail::check_failed(__FILE__, __LINE__, #condition);                       \
        }                                                                                          \
    } while (false)

#define PROXIMA_CHECK_OPERATOR(a, op, b)                                                           \
    do {                                                                                           \
        const auto& proxima_check_a = (a);                                                         \
        const auto& proxima_check_b = (b);                                                         \
        if (!(proxima_check_a op proxima_check_b)) [[unlikely]] {                                  \
            ::proxima::detail::check_failed(__FILE__, __LINE__,                                    \
                                            ::proxima::concat(#a " " #op " " #b " (",              \
                                                              proxima_check_a, " against ",        \
                                                              proxima_check_b, ")"));              \
        }                                                                                          \
    } while (false)

#define PROXIMA_CHECK_EQ(a, b) PROXIMA_CHECK_OPERATOR(a, ==, b)
#define PROXIMA_CHECK_NE(a, b) PROXIMA_CHECK_OPERATOR(a, !=, b)
#define PROXIMA_CHECK_LT(a, b) PROXIMA_CHECK_OPERATOR(a, <, b)
#define PROXIMA_CHECK_LE(a, b) PROXIMA_CHECK_OPERATOR(a, <=, b)
#define PROXIMA_CHECK_GT(a, b) PROXIMA_CHECK_OPERATOR(a, >, b)
#define PROXIMA_CHECK_GE(a, b) PROXIMA_CHECK_OPERATOR(a, >=, b)
