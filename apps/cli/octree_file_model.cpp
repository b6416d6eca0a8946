#include "cli/octree_file_model.h"

#include "base/file_extension.h"
#include "base/text.h"
#include "cli/index_file_model.h"
#include "proxima/octree_io.h"

#include <CLI/CLI.hpp>

namespace proxima {

bool is_octree_file(const std::string& model)
{
    return lower_case_extension(model) == ".pxo";
}

void add_mesh_option(CLI::App& parser, const std::string& model, ModelKinds kinds,
                     std::string& mesh, std::vector<std::string> not_for_files)
{
    const bool all = kinds == ModelKinds::meshes_octrees_and_indexes;
    parser
        .add_option("--mesh", mesh,
                    all ? "The mesh that a saved octree or index was built from"
                        : "The mesh that a saved octree was built from")
        ->type_name("MODEL");
    parser.parse_complete_callback([&parser, &model, all, names = std::move(not_for_files)] {
        if (!is_octree_file(model) && !(all && is_index_file(model))) {
            if (parser.count("--mesh") == 0) return;
            throw CLI::ValidationError(
                "--mesh",
                concat("it goes with an ",
                       all ? "octree or index file (.pxo, .pxi)" : "octree file (.pxo)", " alone"));
        }
        for (const std::string& name : names) {
            if (parser.count(name) == 0) continue;
            throw CLI::ValidationError(
                name, concat("an octree file is built already: leave it out or give a mesh "
                             "instead of ",
                             model));
        }
    });
}

Result<Octree> load_octree_file(const std::string& path, Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    return load_octree(path, {.execution = session.execution()});
}

Result<TriangleMesh> load_mesh_of(const Octree& octree, const std::string& mesh, Session& session)
{
    if (mesh.empty()) return TriangleMesh{};
    auto loaded = session.load_model(mesh);
    if (!loaded) return loaded;
    if (loaded->triangle_count() != octree.triangle_count()) {
        return fail(ErrorCode::invalid_argument,
                    concat("this is not the octree's mesh: it has ", loaded->triangle_count(),
                           " triangles, the octree was built from ", octree.triangle_count()),
                    mesh);
    }
    const Box root = octree.box(octree.root());
    const Box bounds = bounding_box(*loaded);
    if (!root.contains(bounds.lower) || !root.contains(bounds.upper)) {
        return fail(ErrorCode::invalid_argument,
                    "this is not the octree's mesh: it reaches out of the root cell", mesh);
    }
    return loaded;
}

} // namespace proxima
