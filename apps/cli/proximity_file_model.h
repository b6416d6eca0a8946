// A saved proximity octree in the place of MODEL, and the surface that it was built of.
#pragma once

#include "cli/session.h"
#include "index/lists/proximity_octree.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <string>
#include <vector>

namespace CLI {
class App;
} // namespace CLI

namespace proxima {

/// Whether a MODEL is a proximity octree, by its extension.
[[nodiscard]] bool is_proximity_file(const std::string& model);

/// Wrong usage where an option of these names, which say how to build, stands beside a proximity
/// octree that is built already. `model` outlives the parser.
void refuse_beside_proximity_file(CLI::App& parser, const std::string& model,
                                  std::vector<std::string> names);

/// The octree of the file. Errors as load_proximity_octree.
[[nodiscard]] Result<ProximityOctree> load_proximity_file(const std::string& path,
                                                          Session& session);

struct ModelSurface {
    TriangleMesh mesh;
    Topology topology;
};

/// The mesh with its topology. Errors as build_topology, with the model as their place.
[[nodiscard]] Result<ModelSurface> surface_of(TriangleMesh mesh, const std::string& model,
                                              Session& session);

/// The same of an octree's mesh, whose edges answers name. Error malformed_file where a crafted
/// file has no such mesh.
[[nodiscard]] Result<ModelSurface> surface_of(const ProximityOctree& octree,
                                              const std::string& model, Session& session);

} // namespace proxima
