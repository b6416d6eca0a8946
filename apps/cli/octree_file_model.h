// A saved octree in the place of MODEL, and the mesh that may be named beside it.
#pragma once

#include "cli/model_options.h"
#include "cli/session.h"
#include "proxima/octree.h"
#include "proxima/result.h"

#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
} // namespace CLI

namespace proxima {

/// Whether a MODEL is an octree file, by its extension.
[[nodiscard]] bool is_octree_file(const std::string& model);

/// --mesh MODEL, for saved octrees of these kinds alone. Wrong usage where it stands beside another
/// MODEL, or one of `not_for_files` beside a saved octree. `model` and `mesh` outlive the parser.
void add_mesh_option(CLI::App& parser, const std::string& model, ModelKinds kinds,
                     std::string& mesh, std::vector<std::string> not_for_files);

/// The octree of the file. Errors as load_octree.
[[nodiscard]] Result<Octree> load_octree_file(const std::string& path, Session& session);

/// The mesh of --mesh; one without triangles where none was named. Errors as load_model, and
/// invalid_argument where the octree cannot be of that mesh.
[[nodiscard]] Result<TriangleMesh> load_mesh_of(const Octree& octree, const std::string& mesh,
                                                Session& session);

} // namespace proxima
