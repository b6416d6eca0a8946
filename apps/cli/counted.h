// Numbers with the noun that they count.
#pragma once

#include <cstdint>
#include <fmt/core.h>
#include <string>
#include <string_view>

namespace proxima {

/// "1 edge", "2 edges".
[[nodiscard]] inline std::string counted(std::uint64_t count, std::string_view noun,
                                         std::string_view plural)
{
    return fmt::format("{} {}", count, count == 1 ? noun : plural);
}

} // namespace proxima
