// Message text without a formatting library: the core depends on nothing for it.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

namespace proxima {

/// A string, or a value that is still to be written.
using TextPart =
    std::variant<std::string_view, bool, char, std::int64_t, std::uint64_t, float, double>;

/// The value as a part of a text. It refers to strings and does not copy them.
template <class T>
[[nodiscard]] TextPart text_part(const T& value) noexcept
{
    if constexpr (std::convertible_to<const T&, std::string_view>) {
        return std::string_view(value);
    } else if constexpr (std::same_as<T, bool> || std::same_as<T, char> || std::floating_point<T>) {
        return value;
    } else if constexpr (std::signed_integral<T>) {
        return std::int64_t{value};
    } else {
        static_assert(std::unsigned_integral<T>, "texts are made of strings and numbers");
        return std::uint64_t{value};
    }
}

/// The parts one after the other; floating point in the shortest form that reads back to the same
/// bits. One function for all messages: a template for each combination of types took 180 KB of the
/// Python module.
[[nodiscard]] std::string join_parts(std::span<const TextPart> parts);

/// Joins strings and numbers: `concat("line ", 12, ": bad index ", index)`.
template <class... Parts>
[[nodiscard]] std::string concat(const Parts&... parts)
{
    return join_parts(std::array<TextPart, sizeof...(Parts)>{text_part(parts)...});
}

/// Text of one value, as `concat` has it.
template <class T>
[[nodiscard]] std::string to_text(const T& value)
{
    return concat(value);
}

} // namespace proxima
