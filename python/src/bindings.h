// The parts of the module. Docstrings are what Python shows: shapes, units, errors, cost.
#pragma once

#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"

#include <pybind11/pybind11.h>

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
[[nodiscard]] inline py::object result_type(const char* name)
{
    return py::module_::import("proxima._results").attr(name);
}

} // namespace proxima::python
