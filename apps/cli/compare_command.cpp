// proxima compare: thesis Table 3.3 on this machine, the overlap methods against each other.
#include "base/text.h"
#include "cli/commands.h"
#include "cli/method_race.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/text_table.h"

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

struct CompareOptions {
    std::string model;
    MethodRaceOptions race;
};

void add_depths_option(CLI::App& parser, std::vector<int>& depths)
{
    parser
        .add_option_function<std::string>(
            "--depths",
            [&depths](const std::string& text) {
                const auto numbers = parse_numbers(text, 0, max_octree_depth);
                if (!numbers) {
                    throw CLI::ValidationError("--depths",
                                               concat(text, " is no list of depths from 0 to ",
                                                      max_octree_depth, ", such as 1-5 or 3,5"));
                }
                depths = *numbers;
            },
            "Depths to build (default 1-5)")
        ->type_name("LIST");
}

void add_methods_option(CLI::App& parser, std::vector<OverlapMethod>& methods)
{
    parser
        .add_option_function<std::string>(
            "--methods",
            [&methods](const std::string& text) {
                methods.clear();
                for (const std::string& name : split_list(text)) {
                    const auto method = find_method(name);
                    if (!method) {
                        throw CLI::ValidationError(
                            "--methods",
                            concat('"', name, "\" is no method: they are ", method_names()));
                    }
                    methods.push_back(*method);
                }
            },
            concat("Methods to compare (default all): ", method_names()))
        ->type_name("LIST");
}

Status run_compare(const CompareOptions& options, Session& session)
{
    const auto mesh = session.load_model(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    MethodRaceOptions race = options.race;
    race.execution = {session.threads_to_measure(), &session.progress()};
    const auto rows = [&] {
        const ProgressBar shown(session.progress(), session.bar());
        return race_methods(*mesh, race);
    }();
    if (!rows) return at_model(rows.error(), options.model);

    session.print(fmt::format("{}: {} triangles, threshold {}{}, {}, medians of up to {} "
                              "interleaved runs\n\n{}\n{}\n",
                              options.model, mesh->triangle_count(), race.threshold,
                              race.exactness == Exactness::exact ? ", exact" : "",
                              threads_text(race.execution.threads), race.repeats, race_text(*rows),
                              agreement_text(*rows)));
    nlohmann::ordered_json result = {{"model", options.model},
                                     {"triangles", mesh->triangle_count()},
                                     {"rows", nlohmann::ordered_json::array()}};
    for (const RaceRow& row : *rows) {
        nlohmann::ordered_json ratio; // null without separating axes
        if (row.ratio_to_separating_axis) ratio = *row.ratio_to_separating_axis;
        result["rows"].push_back({{"depth", row.depth},
                                  {"method", method_name(row.method)},
                                  {"total", row.total},
                                  {"references", row.references},
                                  {"seconds", row.seconds},
                                  {"ratio_to_separating_axis", ratio}});
    }
    return session.write_json(result);
}

} // namespace

Command add_compare_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "compare", "Compare the times of overlap tests between triangles and cells (Table 3.3)");
    const auto options = std::make_shared<CompareOptions>();
    add_model_option(*parser, options->model);
    add_depths_option(*parser, options->race.depths);
    add_methods_option(*parser, options->race.methods);
    parser
        ->add_option("--threshold", options->race.threshold,
                     "Split cells of more triangles than this")
        ->check(CLI::Range(std::uint32_t{1}, std::numeric_limits<std::uint32_t>::max()))
        ->capture_default_str()
        ->type_name("N");
    parser->add_flag_callback(
        "--exact", [options] { options->race.exactness = Exactness::exact; },
        "Decide overlaps exactly with the thesis's methods too: all then give one octree");
    parser->add_option("--repeats", options->race.repeats, "Runs of each method; the median counts")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str()
        ->type_name("N");
    return {parser, [options](Session& session) { return run_compare(*options, session); }};
}

} // namespace proxima
