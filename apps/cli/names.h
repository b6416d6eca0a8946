// Words of the command line for the library's enums, and lists of numbers as options have them.
#pragma once

#include "proxima/octree/octree.h"

#include <array>
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

} // namespace proxima
