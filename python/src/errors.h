// Errors of the library as Python exceptions.
//
//     proxima.Error            has .code, the name of the ErrorCode
//       InvalidInput           also a ValueError
//       FileMissing            also a FileNotFoundError
//       FileNotWritable        also an OSError
//       LimitExceeded          also a MemoryError
//       Cancelled
#pragma once

#include "proxima/result.h"

#include <cstdint>
#include <exception>
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

private:
    Error error_;
    std::string text_;
};

/// Refuses an argument.
[[noreturn]] inline void refuse(std::string argument, std::string message)
{
    throw Failure({ErrorCode::invalid_argument, std::move(message), std::move(argument)});
}

/// A count from 0 to `most`; refuses others.
[[nodiscard]] inline std::uint32_t count_of(std::int64_t count, const char* name,
                                            std::uint32_t most)
{
    if (count < 0 || count > most) refuse(name, "must be from 0 to " + std::to_string(most));
    return static_cast<std::uint32_t>(count);
}

/// The name of an object's type, for messages.
[[nodiscard]] inline std::string type_name(const py::handle& object)
{
    return Py_TYPE(object.ptr())->tp_name;
}

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
