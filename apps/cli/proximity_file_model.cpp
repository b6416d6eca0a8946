#include "cli/proximity_file_model.h"

#include "base/file_extension.h"
#include "base/text.h"
#include "cli/model_options.h"
#include "index/file/proximity_file.h"
#include "index/lists/octree_mesh.h"

#include <CLI/CLI.hpp>
#include <utility>

namespace proxima {

namespace {

/// What would be a fault of the program in an octree of its own is damage in a file.
tl::unexpected<Error> damaged(const Error& error, const std::string& model)
{
    return fail(ErrorCode::malformed_file, describe(error), model);
}

} // namespace

bool is_proximity_file(const std::string& model)
{
    return lower_case_extension(model) == ".pxp";
}

void refuse_beside_proximity_file(CLI::App& parser, const std::string& model,
                                  std::vector<std::string> names)
{
    parser.parse_complete_callback([&parser, &model, names = std::move(names)] {
        if (!is_proximity_file(model)) return;
        for (const std::string& name : names) {
            if (parser.count(name) == 0) continue;
            throw CLI::ValidationError(
                name, concat("a saved octree is built already: leave it out or give a mesh "
                             "instead of ",
                             model));
        }
    });
}

Result<ProximityOctree> load_proximity_file(const std::string& path, Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    return load_proximity_octree(path, {.execution = session.execution()});
}

Result<ModelSurface> surface_of(TriangleMesh mesh, const std::string& model, Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    auto topology = build_topology(mesh, {.execution = session.execution()});
    if (!topology) return at_model(topology.error(), model);
    return ModelSurface{std::move(mesh), std::move(*topology)};
}

Result<ModelSurface> surface_of(const ProximityOctree& octree, const std::string& model,
                                Session& session)
{
    auto mesh = mesh_of(octree);
    if (!mesh) return damaged(mesh.error(), model);
    auto surface = surface_of(std::move(*mesh), model, session);
    if (!surface) return surface;
    if (const Status status = check_edges(octree, surface->topology); !status)
        return damaged(status.error(), model);
    return surface;
}

} // namespace proxima
