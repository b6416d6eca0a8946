// A model to be touched by benchmarks: a mesh, or the saved octree of one.
#pragma once

#include "haptics/device/workspace_map.h"
#include "haptics/surface/contact_surface.h"
#include "index/lists/proximity_octree.h"
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
    ProximityOctree octree;
    std::unique_ptr<OctreeContactSurface> surface; ///< refers to the octree
    WorkspaceMap map;                              ///< to a ball of 0.1 m
};

/// Of a built-in, a mesh's file, or a proximity octree's (.pxp). A mesh's octree is looked for in
/// the folder `kept`, and saved there once built; an empty name keeps none.
[[nodiscard]] Result<std::unique_ptr<TouchModel>> load_touch_model(const std::string& name,
                                                                   const std::string& kept);

} // namespace proxima::bench
