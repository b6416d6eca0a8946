// A saved mesh index in the place of MODEL, and the surface that it was built of.
#pragma once

#include "cli/session.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <string>
#include <vector>

namespace CLI {
class App;
} // namespace CLI

namespace proxima {

/// Whether a MODEL is a saved mesh index, by its extension.
[[nodiscard]] bool is_index_file(const std::string& model);

/// Wrong usage where an option of these names, which say how to build, stands beside an index
/// that is built already. `model` outlives the parser.
void refuse_beside_index_file(CLI::App& parser, const std::string& model,
                              std::vector<std::string> names);

/// The index of the file. Errors as load_index.
[[nodiscard]] Result<MeshIndex> load_index_file(const std::string& path, Session& session);

/// The index of a model whose mesh was loaded: that of the file, or one that is built. Errors as
/// load_index and build_mesh_index, with the model as their place.
[[nodiscard]] Result<MeshIndex> index_of_model(const std::string& model, const TriangleMesh& mesh,
                                               Session& session);

/// The index with the signs that it has, or with signs that are built. Errors as with_signs, with the
/// model as their place; malformed_file where a crafted file has no such mesh.
[[nodiscard]] Result<MeshIndex> index_with_signs(const MeshIndex& index, const std::string& model,
                                                 Session& session);

struct ModelSurface {
    TriangleMesh mesh;
    Topology topology;
};

/// The mesh with its topology. Errors as build_topology, with the model as their place.
[[nodiscard]] Result<ModelSurface> surface_of(TriangleMesh mesh, const std::string& model,
                                              Session& session);

/// That of an index's mesh, whose edges answers name. Error malformed_file where a crafted
/// file has no such mesh.
[[nodiscard]] Result<ModelSurface> surface_of(const MeshIndex& index, const std::string& model,
                                              Session& session);

} // namespace proxima
