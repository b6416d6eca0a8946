// What a command says on stderr. Where nobody takes it (closed, a full disk, a pipe without a reader) it is lost: that is no
// reason to end. Nothing is allocated, so that running out of memory can be reported, too.
#pragma once

#include <array>
#include <fmt/core.h>
#include <string_view>

namespace proxima {

/// The text as it is.
void write_stderr(std::string_view text) noexcept;

/// A formatted text of up to 511 bytes; what is longer is cut off. \pre formatting the arguments
/// throws nothing: numbers and strings
template <class... Arguments>
void print_stderr( // NOLINT(bugprone-exception-escape): fmt could, for other arguments
    fmt::format_string<Arguments...> form, Arguments&&... arguments) noexcept
{
    std::array<char, 512> text; // NOLINT(*-member-init): written before it is read
    const auto written =
        fmt::format_to_n(text.data(), text.size() - 1, form, std::forward<Arguments>(arguments)...);
    write_stderr({text.data(), static_cast<std::size_t>(written.out - text.data())});
}

} // namespace proxima
