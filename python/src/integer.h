// Integers that Python hands over, of any size: what is out of range is refused by a message that names the argument
// and the range, not by pybind11's list of signatures.
#pragma once

#include <cstdint>
#include <limits>
#include <pybind11/pybind11.h>

namespace proxima::python {

/// An int of Python or NumPy; beyond 64 bits it is clamped.
struct Integer {
    std::int64_t value = 0;
};

} // namespace proxima::python

namespace pybind11::detail {

template <>
struct type_caster<proxima::python::Integer> {
    PYBIND11_TYPE_CASTER(proxima::python::Integer, const_name("int"));

    bool load(handle source, bool /*convert*/)
    {
        const auto whole = reinterpret_steal<object>(PyNumber_Index(source.ptr()));
        if (!whole) {
            if (PyErr_ExceptionMatches(PyExc_TypeError) == 0) throw error_already_set();
            PyErr_Clear();
            return false;
        }
        int overflow = 0;
        value.value = PyLong_AsLongLongAndOverflow(whole.ptr(), &overflow);
        if (overflow > 0) value.value = std::numeric_limits<std::int64_t>::max();
        if (overflow < 0) value.value = std::numeric_limits<std::int64_t>::min();
        return true;
    }
};

} // namespace pybind11::detail
