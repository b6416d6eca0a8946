// What answers the queries of a command: the library's index, or the structure of the thesis.
#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <string_view>

namespace proxima {

enum class QueryMethod : std::uint8_t {
    index, ///< the fast one
    thesis ///< as chapters 4 and 5 of the thesis have it
};

/// Adds --method index|thesis; `how` says what the thesis's method does.
void add_query_method_option(CLI::App& parser, QueryMethod& method, std::string_view how);

[[nodiscard]] std::string_view name_of(QueryMethod method) noexcept;

} // namespace proxima
