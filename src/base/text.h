// Message text without a formatting library: the core depends on nothing for it.
#pragma once

#include <array>
#include <charconv>
#include <concepts>
#include <string>
#include <string_view>

namespace proxima {

/// Text of one value, shortest form that reads back to the same bits for floating point.
template <class T>
[[nodiscard]] std::string to_text(const T& value)
{
    if constexpr (std::convertible_to<const T&, std::string_view>) {
        return std::string(std::string_view(value));
    } else if constexpr (std::same_as<T, bool>) {
        return value ? "true" : "false";
    } else if constexpr (std::same_as<T, char>) {
        return std::string(1, value);
    } else {
        static_assert(std::is_arithmetic_v<T>, "to_text takes strings and numbers");
        std::array<char, 64> buffer{};
        const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
        return {buffer.data(), end};
    }
}

/// Joins strings and numbers: `concat("line ", 12, ": bad index ", index)`.
template <class... Parts>
[[nodiscard]] std::string concat(const Parts&... parts)
{
    std::string text;
    ((text += to_text(parts)), ...);
    return text;
}

} // namespace proxima
