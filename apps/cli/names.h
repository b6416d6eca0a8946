// Words of the command line: names of the library's enums, lists of numbers as options have them.
#pragma once

#include "proxima/octree.h"
#include "proxima/result.h"

#include <array>
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

} // namespace proxima
