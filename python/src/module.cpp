// proxima._core: what python/proxima/__init__.py makes the package of.
#include "bindings.h"
#include "errors.h"

#include <pybind11/pybind11.h>

#include <cstddef>
#include <exception>

namespace {

namespace py = pybind11;

/// Where an object that __new__ made without __init__ is used, pybind11 asks for memory, to which
/// nothing would be written.
void refuse_objects_without_value(const py::module_& module)
{
    const py::handle type_of_types(
        static_cast<PyObject*>(static_cast<void*>(py::detail::get_internals().default_metaclass)));
    for (const auto& [name, thing] : py::dict(module.attr("__dict__"))) {
        if (!py::isinstance(thing, type_of_types)) continue;
        auto* const type = static_cast<PyTypeObject*>(static_cast<void*>(thing.ptr()));
        py::detail::get_type_info(type)->operator_new = [](std::size_t) -> void* {
            throw py::type_error(proxima::python::without_value);
        };
    }
}

newfunc new_instance = nullptr;

/// The common base of all bound classes is none itself: pybind11 throws where it is called, which the interpreter, for the
/// first two protocols of pickle, does from C.
PyObject* new_instance_or_error(PyTypeObject* type, PyObject* arguments, PyObject* keywords)
{
    try {
        return new_instance(type, arguments, keywords);
    } catch (const std::exception& error) {
        PyErr_SetString(PyExc_TypeError, error.what());
        return nullptr;
    }
}

void refuse_objects_of_the_base()
{
    auto* const base =
        static_cast<PyTypeObject*>(static_cast<void*>(py::detail::get_internals().instance_base));
    if (base->tp_new == &new_instance_or_error) return;
    new_instance = base->tp_new;
    base->tp_new = &new_instance_or_error;
    PyType_Modified(base);
}

} // namespace

PYBIND11_MODULE(_core, module)
{
    using namespace proxima::python;
    module.attr("__version__") = PROXIMA_VERSION;
    bind_errors(module);
    bind_mesh(module);
    bind_index(module);
    bind_closest_one(module);
    bind_topology(module);
    bind_octree(module);
    bind_minkowski(module);
    bind_scene(module);
    bind_solid(module);
    bind_touch_scene(module);
    bind_touch_renderer(module);
    refuse_objects_without_value(module);
    refuse_objects_of_the_base();
}
