// proxima._core: what python/proxima/__init__.py makes the package of.
#include "bindings.h"
#include "errors.h"

#include <pybind11/pybind11.h>

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
}
