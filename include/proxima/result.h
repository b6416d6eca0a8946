// The return type of functions that can fail: a value, or one clear error.
//
//     auto mesh = proxima::read_mesh("bunny.obj");          // Result<TriangleMesh>
//     if (!mesh) { std::cerr << describe(mesh.error()); return 1; }
//     use(*mesh);
//
// Errors of input, building and files are returned this way. Nothing found is no error: such
// functions return std::optional. A broken precondition (\pre) is a bug of the caller and ends the
// program with a message.
#pragma once

#include "proxima/export.h"

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace PROXIMA_EXPORT proxima {

/// The kind of an error; the message says it in words.
enum class ErrorCode {
    invalid_argument,   ///< an option or input value outside its documented range
    file_not_found,     ///< no such file, or it cannot be opened for reading
    file_not_writable,  ///< the file cannot be created or written completely
    unsupported_format, ///< an unknown extension, or a variant of a format that is not read
    malformed_file,     ///< a file that is truncated, damaged or contradicts itself
    invalid_mesh,       ///< a mesh that the operation cannot take
    broken_invariant,   ///< an object that contradicts itself or what it was built from
    limit_exceeded,     ///< beyond a documented limit of size or depth
    budget_exceeded,    ///< the work would need more memory than its budget allows
    cancelled           ///< stopped on request; nothing was kept
};

/// One error: what is wrong, where, and what to do about it.
struct Error {
    ErrorCode code{};
    std::string message; ///< what is wrong and what to do, one sentence
    std::string where;   ///< file and line, option or element; may be empty
};

/// A value of type T or an Error.
template <class T>
using Result = tl::expected<T, Error>;

/// Success or an Error.
using Status = Result<void>;

/// Makes the error that a function returns as its Result or Status.
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string message,
                                                std::string where = {})
{
    return tl::unexpected<Error>(Error{code, std::move(message), std::move(where)});
}

/// The error as one line of text: "where: message", or the message alone.
[[nodiscard]] inline std::string describe(const Error& error)
{
    return error.where.empty() ? error.message : error.where + ": " + error.message;
}

} // namespace proxima
