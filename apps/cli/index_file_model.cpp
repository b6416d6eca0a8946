#include "cli/index_file_model.h"

#include "base/file_extension.h"
#include "base/text.h"
#include "cli/model_options.h"
#include "index/check_edges.h"
#include "proxima/index_io.h"
#include "proxima/mesh_index.h"

#include <CLI/CLI.hpp>
#include <utility>

namespace proxima {

namespace {

/// What would be a fault of the program in an index of its own is damage in a file.
tl::unexpected<Error> damaged(const Error& error, const std::string& model)
{
    return fail(ErrorCode::malformed_file, describe(error), model);
}

} // namespace

bool is_index_file(const std::string& model)
{
    return lower_case_extension(model) == ".pxi";
}

void refuse_beside_index_file(CLI::App& parser, const std::string& model,
                              std::vector<std::string> names)
{
    parser.parse_complete_callback([&parser, &model, names = std::move(names)] {
        if (!is_index_file(model)) return;
        for (const std::string& name : names) {
            if (parser.count(name) == 0) continue;
            throw CLI::ValidationError(
                name, concat("a saved index is built already: leave it out or give a mesh "
                             "instead of ",
                             model));
        }
    });
}

Result<MeshIndex> load_index_file(const std::string& path, Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    return load_index(path, {.execution = session.execution()});
}

Result<MeshIndex> index_of_model(const std::string& model, const TriangleMesh& mesh,
                                 Session& session)
{
    if (is_index_file(model)) return load_index(model, {.execution = session.execution()});
    auto index = build_mesh_index(mesh, {.execution = session.execution()});
    if (!index) return at_model(index.error(), model);
    return index;
}

Result<MeshIndex> index_with_signs(const MeshIndex& index, const std::string& model,
                                   Session& session)
{
    if (index.has_signs()) return index;
    const ProgressBar shown(session.progress(), session.bar());
    auto with = with_signs(index, {.execution = session.execution()});
    if (with) return with;
    if (is_index_file(model) && with.error().code == ErrorCode::broken_invariant)
        return damaged(with.error(), model);
    return at_model(with.error(), model);
}

Result<ModelSurface> surface_of(TriangleMesh mesh, const std::string& model, Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    auto topology = build_topology(mesh, {.execution = session.execution()});
    if (!topology) return at_model(topology.error(), model);
    return ModelSurface{std::move(mesh), std::move(*topology)};
}

Result<ModelSurface> surface_of(const MeshIndex& index, const std::string& model, Session& session)
{
    auto mesh = mesh_of(index);
    if (!mesh) return damaged(mesh.error(), model);
    auto surface = surface_of(std::move(*mesh), model, session);
    if (!surface) return surface;
    if (const Status status = check_edges(index, surface->topology); !status)
        return damaged(status.error(), model);
    return surface;
}

} // namespace proxima
