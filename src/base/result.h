// What a fallible operation returns: a value, or one clear error.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace proxima {

/// What kind of thing went wrong; the message says it in words.
enum class ErrorCode {
    invalid_argument,   ///< an option or input value outside its documented range
    file_not_found,     ///< no such file, or it cannot be opened for reading
    file_not_writable,  ///< cannot be created or written completely
    unsupported_format, ///< unknown extension or a variant that is not read
    malformed_file,     ///< truncated, damaged or contradicting itself
    invalid_mesh,       ///< a mesh that the operation cannot take
    broken_invariant,   ///< an object that contradicts itself or what it was built from
    limit_exceeded,     ///< a documented size or depth limit
    budget_exceeded,    ///< would need more memory than the budget allows
    cancelled           ///< stopped on request; nothing was kept
};

/// One error: what, where (a file, line, option or element) and what to do about it.
struct Error {
    ErrorCode code{};
    std::string message; ///< what is wrong and what to do, one sentence
    std::string where;   ///< file and line, option or element; may be empty
};

/// A value or an Error.
template <class T>
using Result = tl::expected<T, Error>;

/// Success or an Error.
using Status = Result<void>;

/// Returns an error from a function whose result is a Result or Status.
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string message,
                                                std::string where = {})
{
    return tl::unexpected<Error>(Error{code, std::move(message), std::move(where)});
}

/// "where: message", or the message alone.
[[nodiscard]] inline std::string describe(const Error& error)
{
    return error.where.empty() ? error.message : error.where + ": " + error.message;
}

} // namespace proxima
