// proxima index: builds what all queries of a mesh ask, with the additions that are asked for, and
// saves it.
#include "cli/commands.h"
#include "cli/index_file_model.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/stopwatch.h"
#include "cli/text_table.h"
#include "proxima/index_io.h"
#include "proxima/mesh_index.h"

#include <CLI/CLI.hpp>
#include <array>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

namespace proxima {

namespace {

struct IndexOptions {
    std::string model;
    std::string save;
    bool lists = false;
    std::uint64_t lists_mb = 0; ///< of lists; 0: the library's own
    bool slabs = false;
    bool signs = false;
};

/// Adds lists, slabs and signs where asked for.
Result<MeshIndex> with_additions(MeshIndex index, const IndexOptions& options, Session& session)
{
    const Execution execution = {.threads = session.threads(), .progress = &session.progress()};
    if (options.lists || options.lists_mb != 0) {
        auto listed =
            with_lists(index, {.list_bytes = options.lists_mb * 1'000'000, .execution = execution});
        if (!listed) return at_model(listed.error(), options.model);
        index = *listed;
    }
    if (options.slabs) {
        auto with = with_slabs(index, {.execution = execution});
        if (!with) return at_model(with.error(), options.model);
        index = *with;
    }
    if (options.signs) {
        auto with = with_signs(index, {.execution = execution});
        if (!with) return at_model(with.error(), options.model);
        index = *with;
    }
    return index;
}

Result<MeshIndex> make_index(const IndexOptions& options, Session& session, double& seconds)
{
    if (is_index_file(options.model)) {
        const Stopwatch watch;
        auto index = load_index_file(options.model, session);
        if (!index) return index;
        const ProgressBar shown(session.progress(), session.bar());
        auto with = with_additions(*index, options, session);
        seconds = watch.seconds();
        return with;
    }
    const auto mesh = session.load_model(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    const ProgressBar shown(session.progress(), session.bar());
    const Stopwatch watch;
    auto index = build_mesh_index(*mesh, {.execution = session.execution()});
    if (!index) return at_model(index.error(), options.model);
    auto with = with_additions(*index, options, session);
    seconds = watch.seconds();
    return with;
}

Status run_index(const IndexOptions& options, Session& session)
{
    if (Status status = session.check_outputs({options.save}); !status) return status;
    if (Status status = check_extension(options.save, ".pxi"); !status) return status;
    double seconds = 0;
    const auto index = make_index(options, session, seconds);
    if (!index) return tl::unexpected(index.error());
    if (!options.save.empty()) {
        const ProgressBar shown(session.progress(), session.bar());
        Status status =
            save_index(*index, options.save, {.execution = {.progress = &session.progress()}});
        if (!status) return status;
    }
    const MeshIndexBytes bytes = bytes_of(*index);
    const std::array<std::pair<const char*, std::uint64_t>, 7> parts = {
        {{"blocks", bytes.blocks},
         {"rows", bytes.rows},
         {"ids", bytes.ids},
         {"incidences", bytes.incidences},
         {"lists", bytes.lists},
         {"slabs", bytes.slabs},
         {"signs", bytes.signs}}};
    const auto triangles = static_cast<double>(index->triangle_count());
    TextTable table({"Part", "Bytes", "Per triangle"});
    // Not null at first: where memory runs out, null that is to become an object is destroyed as one.
    nlohmann::ordered_json per_triangle = nlohmann::ordered_json::object();
    for (const auto& [name, size] : parts) {
        const double each = static_cast<double>(size) / triangles;
        table.add_row({name, std::to_string(size), fmt::format("{:.2f}", each)});
        per_triangle[name] = each;
    }
    const double each = static_cast<double>(index->bytes()) / triangles;
    table.add_row({"all", std::to_string(index->bytes()), fmt::format("{:.2f}", each)});
    session.print(fmt::format("{}: index of {} triangles in {:.3f} s\n\n{}{}", options.model,
                              index->triangle_count(), seconds, table.text(),
                              options.save.empty() ? "" : fmt::format("wrote {}\n", options.save)));
    return session.write_json({{"model", options.model},
                               {"triangles", index->triangle_count()},
                               {"vertices", index->vertex_count()},
                               {"edges", index->edge_count()},
                               {"seconds", seconds},
                               {"bytes", index->bytes()},
                               {"bytes_per_triangle", per_triangle}});
}

} // namespace

Command add_index_command(CLI::App& app)
{
    CLI::App* const parser =
        app.add_subcommand("index", "Build the index that all queries of a mesh use, and save it");
    const auto options = std::make_shared<IndexOptions>();
    add_model_option(*parser, options->model, ModelKinds::meshes_and_indexes);
    parser
        ->add_option("--save", options->save,
                     "Write the index: a .pxi file, which other commands take as MODEL")
        ->type_name("FILE");
    parser->add_flag("--lists", options->lists,
                     "With closest-feature lists, which bound the slowest query");
    add_list_budget_option(*parser, options->lists_mb);
    parser->add_flag("--slabs", options->slabs, "With slabs, which speed up distances of meshes");
    parser->add_flag("--signs", options->signs,
                     "With signs, which tell inside from outside (closest --signed)");
    return {parser, [options](Session& session) { return run_index(*options, session); }};
}

} // namespace proxima
