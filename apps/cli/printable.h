// Text that a terminal can show.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace proxima {

/// Bytes of the printable character that `text` begins with, 0 where it begins with a control
/// character, those that change the direction of writing included, or is no UTF-8.
[[nodiscard]] std::size_t utf8_length(std::string_view text) noexcept;

/// Hands `text` on in pieces that a terminal can show: printable characters as they are, each other
/// byte as \xNN. Allocates nothing.
template <class Take>
void for_each_printable(std::string_view text, const Take& take)
{
    constexpr std::string_view digits = "0123456789ABCDEF";
    while (!text.empty()) {
        const std::size_t length = utf8_length(text);
        if (length > 0) {
            take(text.substr(0, length));
        } else {
            const auto byte = static_cast<unsigned char>(text[0]);
            const std::array<char, 4> escaped = {'\\', 'x', digits[byte / 16U], digits[byte % 16U]};
            take(std::string_view(escaped.data(), escaped.size()));
        }
        text.remove_prefix(length > 0 ? length : 1);
    }
}

/// What for_each_printable makes of a line feed.
inline constexpr std::string_view escaped_line_feed = "\\x0A";

/// The pieces of for_each_printable as one text.
[[nodiscard]] std::string printable(std::string_view text);

} // namespace proxima
