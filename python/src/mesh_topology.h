// What proxima.Topology holds.
#pragma once

#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <pybind11/pybind11.h>

namespace proxima::python {

/// The topology with Python's mesh, which rings are searched in.
struct MeshTopology {
    pybind11::object owner;
    const TriangleMesh* mesh = nullptr;
    Topology topology;
};

} // namespace proxima::python
