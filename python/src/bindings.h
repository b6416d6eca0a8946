// The parts of the module. Docstrings are what Python shows: shapes, units, errors, cost.
#pragma once

#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"

#include <cxxabi.h>
#include <pybind11/pybind11.h>
#include <unistd.h>
#include <utility>

namespace proxima::python {

namespace py = pybind11;

void bind_mesh(py::module_& module);
void bind_mesh_repair(py::class_<TriangleMesh>& mesh);
void bind_index(py::module_& module);
void bind_closest_one(py::module_& module);
void bind_topology(py::module_& module);
void bind_octree(py::module_& module);
void bind_octree_cells(py::class_<Octree>& octree);
void bind_touch_scene(py::module_& module);
void bind_touch_renderer(py::module_& module);
void bind_minkowski(py::module_& module);
void bind_scene(py::module_& module);
void bind_solid(py::module_& module);

/// Error for an object that __new__ made without __init__.
inline constexpr const char* without_value =
    "the object was made by __new__ alone and holds nothing: call its class instead";

/// A class of proxima/_results.py, the named tuples of arrays that queries return.
class ResultType : public py::object {
public:
    explicit ResultType(const char* name)
        : py::object(py::module_::import("proxima._results").attr(name))
    {}

    /// An object of the class. It is made in Python, which takes its lock anew now and then: a daemon thread that
    /// wants it after the interpreter has ended stays here (see Unlocked), as unwinding would let go of arrays.
    template <class... Arguments>
    [[nodiscard]] py::object operator()(Arguments&&... arguments) const
    {
        const auto given =
            py::detail::collect_arguments<py::return_value_policy::automatic_reference>(
                std::forward<Arguments>(arguments)...);
        const py::dict named = given.kwargs();
        PyObject* const made = [&] {
            try {
                return PyObject_Call(ptr(), given.args().ptr(), named.ptr());
            } catch (const abi::__forced_unwind&) {
                for (;;) pause();
            }
        }();
        if (made == nullptr) throw py::error_already_set();
        return py::reinterpret_steal<py::object>(made);
    }
};

[[nodiscard]] inline ResultType result_type(const char* name)
{
    return ResultType(name);
}

} // namespace proxima::python
