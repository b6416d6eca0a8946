// proxima proximity: builds the closest-feature lists of a mesh and counts them.
#include "base/file_extension.h"
#include "base/text.h"
#include "cli/commands.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/number_checks.h"
#include "cli/plot.h"
#include "cli/proximity_command_options.h"
#include "index/lists/grow_cells.h"
#include "proxima/mesh_index.h"
#include "proxima/octree.h"

#include <CLI/CLI.hpp>
#include <limits>
#include <memory>

namespace proxima {

namespace {

Status check_cell_outputs(const ProximityCommandOptions& options)
{
    for (const std::string& path : options.outs) {
        const std::string extension = lower_case_extension(path);
        if (extension != ".vtu" && extension != ".htg") {
            return fail(ErrorCode::unsupported_format,
                        "unknown extension: cells are written to .vtu or .htg", path);
        }
    }
    return {};
}

Status run_proximity(const ProximityCommandOptions& options, Session& session)
{
    std::vector<std::string> outputs = options.histograms;
    outputs.insert(outputs.end(), options.budget_curves.begin(), options.budget_curves.end());
    for (const std::string& path : outputs) {
        if (path == "-") continue; // session.check_outputs says what is wrong with it
        if (Status status = check_plot_format(path); !status) return status;
    }
    outputs.insert(outputs.end(), options.outs.begin(), options.outs.end());
    outputs.push_back(options.save);
    if (Status status = session.check_outputs(outputs); !status) return status;
    if (Status status = check_extension(options.save, ".pxi"); !status) return status;
    if (Status status = check_cell_outputs(options); !status) return status;
    if (!options.budget_curves.empty()) return run_budget_curve(options, session);
    return options.method == ProximityMethod::thesis ? run_thesis_proximity(options, session)
                                                     : run_general_proximity(options, session);
}

void add_proximity_method_option(CLI::App& parser, ProximityMethod& method)
{
    parser
        .add_option_function<std::string>(
            "--method",
            [&method](const std::string& name) {
                if (name != "general" && name != "thesis") {
                    throw CLI::ValidationError(
                        "--method", concat(name, " is no method: they are general, thesis"));
                }
                method = name == "thesis" ? ProximityMethod::thesis : ProximityMethod::general;
            },
            "general: for any model (default); thesis: for convex ones, as in its chapter 4")
        ->type_name("NAME");
}

void add_depth_option(CLI::App& parser, std::vector<int>& depths)
{
    parser
        .add_option_function<std::string>(
            "--depth",
            [&depths](const std::string& text) {
                const auto numbers = parse_numbers(text, 0, max_octree_depth);
                if (!numbers) {
                    throw CLI::ValidationError(
                        "--depth", concat(text, " is no depth from 0 to ", max_octree_depth,
                                          " and no list of them, such as 1-6"));
                }
                depths = *numbers;
            },
            "Deepest level, the root is 0; or several: 1-6 (default as deep as the budget allows; "
            "thesis 5)")
        ->type_name("N");
}

void add_threshold_options(CLI::App& parser, KindThresholds& thresholds)
{
    const auto range = CLI::Range(std::uint32_t{0}, std::numeric_limits<std::uint32_t>::max());
    CLI::Option* const all =
        parser
            .add_option_function<std::uint32_t>(
                "--threshold",
                [&thresholds](std::uint32_t count) {
                    thresholds = {count, count, count};
                },
                "Thesis: split cells that list more of any kind than this; 0: all (default 1)")
            ->check(range)
            ->type_name("N");
    const auto add = [&](const char* name, std::uint32_t& threshold, const char* kind) {
        parser.add_option(name, threshold, concat("The same for ", kind, " alone"))
            ->check(range)
            ->excludes(all)
            ->type_name("N");
    };
    add("--threshold-vertex", thresholds.vertex, "vertices");
    add("--threshold-edge", thresholds.edge, "edges");
    add("--threshold-face", thresholds.face, "faces");
}

/// The largest margin that each method takes; NaN is none.
void check_margin(const ProximityCommandOptions& options)
{
    const double largest =
        options.method == ProximityMethod::thesis ? max_root_margin : max_list_margin;
    if (options.margin >= 0 && options.margin <= largest) return;
    throw CLI::ValidationError("--margin", concat(options.margin, " is no margin: 0 to ", largest,
                                                  options.method == ProximityMethod::thesis
                                                      ? " with --method thesis"
                                                      : " with the general method"));
}

/// What the method has no use for is wrong usage, and its own depth goes where none is named.
void settle(const CLI::App& parser, ProximityCommandOptions& options)
{
    check_margin(options);
    if (options.method == ProximityMethod::thesis) {
        for (const char* const name : {"--budget-curve", "--lists-mb", "--save", "--out"}) {
            if (parser.count(name) > 0)
                throw CLI::ValidationError(name, "it goes with --method general");
        }
        if (options.depths.empty()) options.depths = {5};
        return;
    }
    for (const char* const name : {"--budget-curve", "--save", "--out"}) {
        if (options.depths.size() > 1 && parser.count(name) > 0)
            throw CLI::ValidationError(name, "it is of one depth: name one or none");
    }
    for (const char* const name : {"--flat", "--budget-mb", "--threshold", "--threshold-vertex",
                                   "--threshold-edge", "--threshold-face"}) {
        if (parser.count(name) == 0) continue;
        throw CLI::ValidationError(
            name, "it goes with --method thesis; the general method splits as --lists-mb allows");
    }
    if (options.depths.empty()) options.depths = {max_list_depth};
    if (options.depths.back() > max_list_depth) {
        throw CLI::ValidationError("--depth",
                                   concat("the general method goes to depth ", max_list_depth,
                                          ", not ", options.depths.back()));
    }
}

} // namespace

Command add_proximity_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "proximity", "Build the proximity octree of a mesh and report the lengths of its lists");
    const auto options = std::make_shared<ProximityCommandOptions>();
    add_model_option(*parser, options->model);
    add_proximity_method_option(*parser, options->method);
    add_depth_option(*parser, options->depths);
    add_threshold_options(*parser, options->thresholds);
    parser
        ->add_option("--margin", options->margin,
                     concat("How much longer the root's edge is than that of the tight cube around "
                            "the mesh, as a fraction: 0 to ",
                            max_list_margin, ", thesis to ", max_root_margin))
        ->capture_default_str()
        ->type_name("M");
    parser
        ->add_option("--flat", options->flat,
                     "With --method thesis: edges are flat, without a region of their own, where 1 "
                     "- cos of the faces' angle is below this (1e-5 gives the thesis's 4850 edges)")
        ->check(number_between(0.0, 1.0))
        ->type_name("C");
    add_list_budget_option(*parser, options->lists_mb);
    add_budget_option(*parser, options->budget_mb,
                      "With --method thesis: memory its build may use, in 10^6 bytes (default: 3/4 "
                      "of the machine's)");
    parser
        ->add_option("--save", options->save,
                     "Write the index with the lists: .pxi (general method)")
        ->type_name("FILE");
    parser
        ->add_option(
            "--out", options->outs,
            "Write its cells with the lengths of their lists: .vtu, .htg (general method); again "
            "for more")
        ->allow_extra_args(false)
        ->type_name("FILE");
    parser
        ->add_option(
            "--histogram", options->histograms,
            "Write how long the lists of leaves are, by volume (thesis: of outer cells, by "
            "number): .csv, .svg, .pdf, .png")
        ->allow_extra_args(false)
        ->type_name("FILE");
    parser
        ->add_option("--budget-curve", options->budget_curves,
                     "Instead: time queries with octrees of 100 to 12000 bytes per triangle, to "
                     ".csv, .svg, .pdf, .png (general method)")
        ->excludes("--lists-mb")
        ->excludes("--save")
        ->excludes("--out")
        ->excludes("--histogram")
        ->allow_extra_args(false)
        ->type_name("FILE");
    parser->parse_complete_callback([parser, options] { settle(*parser, *options); });
    return {parser, [options](Session& session) { return run_proximity(*options, session); }};
}

} // namespace proxima
