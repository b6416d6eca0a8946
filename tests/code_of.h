// The code of an error, for tests: reading the error of a success would give whatever lies in its place.
#pragma once

#include "proxima/result.h"

#include <optional>

namespace proxima {

/// Nothing for a success.
template <class T>
[[nodiscard]] std::optional<ErrorCode> code_of(const tl::expected<T, Error>& result)
{
    if (result) return std::nullopt;
    return result.error().code;
}

} // namespace proxima
