// Words of the command line: names of the library's enums, lists of numbers as options have them,
// text that a terminal can show.
#pragma once

#include "proxima/octree.h"
#include "proxima/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

/// All five methods, the fast one first.
inline constexpr std::array all_methods = {OverlapMethod::fast, OverlapMethod::separating_axis,
                                           OverlapMethod::index_tracking, OverlapMethod::minkowski,
                                           OverlapMethod::pairwise};

/// "fast", "index-tracking", ...
[[nodiscard]] std::string_view method_name(OverlapMethod method) noexcept;

/// The method of that name.
[[nodiscard]] std::optional<OverlapMethod> find_method(std::string_view name) noexcept;

/// "fast, separating-axis, ...", for messages.
[[nodiscard]] std::string method_names();

/// Splits at commas; no part is dropped, so "a,,b" has three.
[[nodiscard]] std::vector<std::string> split_list(std::string_view text);

/// Numbers of a list such as "1-5" or "1,3-4": ascending, each once; nothing if it is no such list
/// or a number lies outside [lowest, highest].
[[nodiscard]] std::optional<std::vector<int>> parse_numbers(std::string_view text, int lowest,
                                                            int highest);

/// A whole number of 64 bits, without sign; nothing if it is none, or too large.
[[nodiscard]] std::optional<std::uint64_t> parse_whole(std::string_view text);

/// Numbers of a list such as "1,-2.5e3"; nothing if a part is no finite number.
[[nodiscard]] std::optional<std::vector<double>> parse_finite_numbers(std::string_view text);

/// The word that somebody may have meant who typed `text`: one that few letters tell from it. Empty
/// where there is none.
[[nodiscard]] std::string similar_word(std::string_view text,
                                       const std::vector<std::string>& words);

/// Error unsupported_format for a file of our own kind without the extension that it is opened by.
/// Empty names and devices are right.
[[nodiscard]] Status check_extension(const std::string& path, std::string_view extension);

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
