// A model to be touched by benchmarks: a mesh, or the saved index of one.
#pragma once

#include "base/result.h"
#include "haptics/device/workspace_map.h"
#include "haptics/surface/contact_surface.h"
#include "index/mesh_index.h"
#include "mesh/topology.h"
#include "mesh/triangle_mesh.h"

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

/// Of a built-in, a mesh's file, or a saved index's (.pxi). A mesh's index is looked for in
/// the folder `kept`, and saved there once built; an empty name keeps none.
[[nodiscard]] Result<std::unique_ptr<TouchModel>> load_touch_model(const std::string& name,
                                                                   const std::string& kept);

} // namespace proxima::bench
