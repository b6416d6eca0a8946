// proxima._core: what python/proxima/__init__.py makes the package of.
#include "bindings.h"
#include "errors.h"

#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstddef>

namespace {

namespace py = pybind11;

/// Calls visit(class, its type) for all bound classes.
template <class Visit>
void visit_classes(const py::module_& module, const Visit& visit)
{
    const py::handle type_of_types(
        static_cast<PyObject*>(static_cast<void*>(py::detail::get_internals().default_metaclass)));
    for (const auto& [name, thing] : py::dict(module.attr("__dict__"))) {
        if (py::isinstance(thing, type_of_types))
            visit(thing, static_cast<PyTypeObject*>(static_cast<void*>(thing.ptr())));
    }
}

/// Where an object that __new__ made without __init__ is used, pybind11 asks for memory, to which
/// nothing would be written.
void refuse_objects_without_value(const py::module_& module)
{
    visit_classes(module, [](const py::handle&, PyTypeObject* type) {
        py::detail::get_type_info(type)->operator_new = [](std::size_t) -> void* {
            throw py::type_error(proxima::python::without_value);
        };
    });
}

/// The first two protocols of pickle make an object of the common base of all bound classes, from C, where pybind11 throws.
/// They can write what the third one asks of a class.
void pickle_by_new_protocols(const py::module_& module)
{
    const auto reduce = [](const py::object& self, int protocol) -> py::object {
        const py::object object = py::module_::import("builtins").attr("object");
        return object.attr("__reduce_ex__")(self, std::max(protocol, 2));
    };
    visit_classes(module, [&](const py::handle& bound, PyTypeObject*) {
        if (!bound.attr("__dict__").contains("__reduce__")) {
            bound.attr("__reduce_ex__") =
                py::cpp_function(reduce, py::name("__reduce_ex__"), py::is_method(bound));
        }
    });
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
    pickle_by_new_protocols(module);
}
