// A model to be touched by benchmarks: a mesh, or the saved index of one.
#pragma once

#include "haptics/surface/contact_surface.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <memory>
#include <string>

namespace proxima::bench {

struct TouchModel {
    std::string name;
    TriangleMesh mesh;
    Topology topology;
    MeshIndex index;
    std::unique_ptr<IndexContactSurface> surface;
    WorkspaceMap map; ///< to a ball of 0.1 m
};

/// Loads a built-in mesh, a mesh file or a saved index (.pxi). The index of a mesh is looked for in
/// the folder `kept`, and saved there once built; an empty name keeps none.
[[nodiscard]] Result<std::unique_ptr<TouchModel>> load_touch_model(const std::string& name,
                                                                   const std::string& kept);

} // namespace proxima::bench
