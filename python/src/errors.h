// Errors of the library as Python exceptions.
//
//     proxima.Error            has .code, the name of the ErrorCode
//       InvalidInput           also a ValueError
//       FileMissing            also a FileNotFoundError
//       FileNotWritable        also an OSError
//       LimitExceeded          also a MemoryError
//       Cancelled
#pragma once

#include "integer.h"
#include "proxima/result.h"

#include <cstdint>
#include <exception>
#include <limits>
#include <pybind11/pybind11.h>
#include <string>
#include <utility>

namespace proxima::python {

namespace py = pybind11;

/// An error on its way to Python.
class Failure : public std::exception {
public:
    explicit Failure(Error error) : error_(std::move(error)), text_(describe(error_)) {}
    [[nodiscard]] const char* what() const noexcept override { return text_.c_str(); }
    [[nodiscard]] const Error& error() const noexcept { return error_; }
    [[nodiscard]] const std::string& text() const noexcept { return text_; }

private:
    Error error_;
    std::string text_;
};

/// Refuses an argument.
[[noreturn]] inline void refuse(std::string argument, std::string message)
{
    throw Failure({ErrorCode::invalid_argument, std::move(message), std::move(argument)});
}

/// The limit of counts that nothing else bounds.
inline constexpr std::int64_t any_count = std::numeric_limits<std::int64_t>::max();

/// A count from `least` to `most`; refuses others.
[[nodiscard]] std::uint64_t count_of(Integer count, const char* name, std::int64_t most = any_count,
                                     std::int64_t least = 0);

/// Refuses numbers below 0 and NaN.
void check_not_negative(double number, const char* name);

/// The name of an object's type, for messages.
[[nodiscard]] inline std::string type_name(const py::handle& object)
{
    return Py_TYPE(object.ptr())->tp_name;
}

/// The text of a str. Characters that UTF-8 cannot encode, such as lone surrogates, are escaped.
[[nodiscard]] std::string text_of(const py::handle& text);

/// Refuses an object of another type. `wanted` says what it must be: "a proxima.Motion".
[[noreturn]] void refuse_object(const py::handle& object, const char* name, const char* wanted);

template <class T>
[[nodiscard]] T value_of(Result<T> result)
{
    if (!result) throw Failure(std::move(result.error()));
    if constexpr (!std::is_void_v<T>) return *std::move(result);
}

/// Sets Python's error.
void set_error(const Failure& failure);

/// Adds the exceptions to the module, and what turns Failures into them.
void bind_errors(py::module_& module);

} // namespace proxima::python
