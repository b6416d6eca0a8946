#include "errors.h"

#include <array>

namespace proxima::python {

namespace {

const char* name_of(ErrorCode code) noexcept
{
    switch (code) {
    case ErrorCode::invalid_argument:
        return "invalid_argument";
    case ErrorCode::file_not_found:
        return "file_not_found";
    case ErrorCode::file_not_writable:
        return "file_not_writable";
    case ErrorCode::unsupported_format:
        return "unsupported_format";
    case ErrorCode::malformed_file:
        return "malformed_file";
    case ErrorCode::invalid_mesh:
        return "invalid_mesh";
    case ErrorCode::broken_invariant:
        return "broken_invariant";
    case ErrorCode::limit_exceeded:
        return "limit_exceeded";
    case ErrorCode::budget_exceeded:
        return "budget_exceeded";
    case ErrorCode::cancelled:
        break;
    }
    return "cancelled";
}

/// Never freed: exceptions may be raised while the interpreter ends.
struct ExceptionTypes {
    py::handle error;
    py::handle invalid_input;
    py::handle file_missing;
    py::handle file_not_writable;
    py::handle limit_exceeded;
    py::handle cancelled;
};

ExceptionTypes types;

py::handle type_of(ErrorCode code) noexcept
{
    switch (code) {
    case ErrorCode::file_not_found:
        return types.file_missing;
    case ErrorCode::file_not_writable:
        return types.file_not_writable;
    case ErrorCode::limit_exceeded:
    case ErrorCode::budget_exceeded:
        return types.limit_exceeded;
    case ErrorCode::cancelled:
        return types.cancelled;
    default:
        return types.invalid_input;
    }
}

} // namespace

std::uint64_t count_of(Integer count, const char* name, std::int64_t most, std::int64_t least)
{
    if (count.value >= least && count.value <= most) return static_cast<std::uint64_t>(count.value);
    const std::string from = std::to_string(least);
    refuse(name, most == any_count ? "must be " + from + " or more"
                                   : "must be from " + from + " to " + std::to_string(most));
}

void check_not_negative(double number, const char* name)
{
    if (!(number >= 0))
        refuse(name, "must be 0 or more, is " + py::str(py::float_(number)).cast<std::string>());
}

void refuse_object(const py::handle& object, const char* name, const char* wanted)
{
    throw py::type_error(std::string(name) + ": must be " + wanted + ", is a " + type_name(object));
}

std::string text_of(const py::handle& text)
{
    const auto bytes = py::reinterpret_steal<py::bytes>(
        PyUnicode_AsEncodedString(text.ptr(), "utf-8", "backslashreplace"));
    if (!bytes) throw py::error_already_set();
    return bytes;
}

void set_error(const Failure& failure)
{
    const ErrorCode code = failure.error().code;
    // Names of files need not be UTF-8.
    const std::string& said = failure.text();
    const auto text = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
        said.data(), static_cast<py::ssize_t>(said.size()), "backslashreplace"));
    if (!text) throw py::error_already_set();
    py::object exception = py::reinterpret_borrow<py::object>(type_of(code))(text);
    exception.attr("code") = name_of(code);
    PyErr_SetObject(type_of(code).ptr(), exception.ptr());
}

void bind_errors(py::module_& module)
{
    const auto add = [&](const char* name, const char* doc, const py::tuple& bases) {
        const std::string full = std::string("proxima.") + name;
        auto type = py::reinterpret_steal<py::object>(
            PyErr_NewExceptionWithDoc(full.c_str(), doc, bases.ptr(), nullptr));
        if (!type) throw py::error_already_set();
        module.attr(name) = type;
        return type.release();
    };
    types.error = add("Error", "Any error of Proxima. `code` names its kind.",
                      py::make_tuple(py::handle(PyExc_Exception)));
    const auto both = [&](PyObject* other) {
        return py::make_tuple(types.error, py::handle(other));
    };
    types.invalid_input =
        add("InvalidInput", "An argument, a mesh or a file that cannot be used; a ValueError.",
            both(PyExc_ValueError));
    types.file_missing =
        add("FileMissing", "No such file, or it cannot be read; a FileNotFoundError.",
            both(PyExc_FileNotFoundError));
    types.file_not_writable =
        add("FileNotWritable", "A file that cannot be written; an OSError.", both(PyExc_OSError));
    types.limit_exceeded =
        add("LimitExceeded", "More than a documented limit or than memory allows; a MemoryError.",
            both(PyExc_MemoryError));
    types.cancelled = add("Cancelled", "Stopped because the progress callback returned False.",
                          py::make_tuple(types.error));
    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown) std::rethrow_exception(std::move(thrown));
        } catch (const Failure& failure) {
            set_error(failure);
        }
    });
}

} // namespace proxima::python
