// proxima minkowski: the sum of two convex models, and what it costs by each method.
#include "base/text.h"
#include "cli/commands.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/number_checks.h"
#include "cli/stopwatch.h"
#include "cli/text_table.h"
#include "minkowski/export_sum.h"
#include "minkowski/operation_counts.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "proxima/thesis.h"
#include "thesis/minkowski_sums/count_sum_by_method.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::array<std::string, 2> models;
    MinkowskiMethod method = MinkowskiMethod::arcs;
    double scale = 1;
    double tolerance = 1e-9;
    bool take_hull = false;
    bool count_operations = false;
    std::string out;
};

constexpr std::array methods = {MinkowskiMethod::arcs, MinkowskiMethod::geometric,
                                MinkowskiMethod::hull};

const char* name_of(MinkowskiMethod method)
{
    switch (method) {
    case MinkowskiMethod::geometric:
        return "geometric";
    case MinkowskiMethod::hull:
        return "hull";
    case MinkowskiMethod::arcs:
        break;
    }
    return "arcs";
}

Result<ConvexPolyhedron> load_operand(const std::string& model, const Options& options,
                                      Session& session)
{
    const auto mesh = session.load_model(model);
    if (!mesh) return tl::unexpected(mesh.error());
    auto polyhedron = options.take_hull
                          ? convex_hull(mesh->positions(), {}, session.execution())
                          : polyhedron_of_mesh(*mesh, {options.tolerance, session.execution()});
    if (polyhedron) return polyhedron;
    Error error = polyhedron.error();
    // Nothing helps where there is no mesh or no number.
    const bool has_hull = checked_bounding_box(*mesh).has_value();
    if (error.code == ErrorCode::invalid_mesh && !options.take_hull && has_hull)
        error.message += " (--hull takes the convex hull)";
    return at_model(std::move(error), model);
}

Json json_of(const OperationCounts& counts)
{
    return {{"dot_products", counts.dot_products},
            {"cross_products", counts.cross_products},
            {"flops", counts.flops()},
            {"additions", counts.additions},
            {"subtractions", counts.subtractions},
            {"multiplications", counts.multiplications},
            {"divisions", counts.divisions},
            {"negations", counts.negations},
            {"comparisons", counts.comparisons}};
}

/// Table 3.2's construction rows for these operands.
struct CountedMethods {
    std::string text;
    Json json = Json::object();
};

Result<CountedMethods> count_methods(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                     Session& session)
{
    CountedMethods result;
    TextTable table(
        {"Method", "Dots", "Crosses", "Flops", "Add", "Sub", "Mul", "Div", "Neg", "Compare"});
    for (const MinkowskiMethod method : methods) {
        const auto counted = count_minkowski_sum(method, a, b, &session.progress());
        if (!counted) {
            if (counted.error().code == ErrorCode::cancelled)
                return tl::unexpected(counted.error());
            result.text += concat(name_of(method), ": ", counted.error().message, "\n");
            result.json[name_of(method)] = {{"error", counted.error().message}};
            continue;
        }
        const OperationCounts& counts = counted->counts;
        table.add_row({name_of(method), to_text(counts.dot_products),
                       to_text(counts.cross_products), to_text(counts.flops()),
                       to_text(counts.additions), to_text(counts.subtractions),
                       to_text(counts.multiplications), to_text(counts.divisions),
                       to_text(counts.negations), to_text(counts.comparisons)});
        result.json[name_of(method)] = json_of(counts);
    }
    result.text =
        concat("\nOperations, counted while the code runs on counting numbers; flops leave "
               "out comparisons and negations\n\n",
               table.text(), result.text);
    return result;
}

Json json_of(const ConvexPolyhedron& polyhedron, const std::string& model)
{
    return {{"model", model},
            {"vertices", polyhedron.vertex_count()},
            {"edges", polyhedron.edges().size()},
            {"facets", polyhedron.facet_count()}};
}

Status run_minkowski(const Options& options, Session& session)
{
    if (Status status = session.check_outputs({options.out}); !status) return status;
    if (!options.out.empty()) {
        if (Status status = check_sum_format(options.out); !status) return status;
    }
    const ProgressBar shown(session.progress(), session.bar());
    const auto a = load_operand(options.models[0], options, session);
    if (!a) return tl::unexpected(a.error());
    auto b = load_operand(options.models[1], options, session);
    if (!b) return tl::unexpected(b.error());
    if (options.scale < 0) b = mirrored(*b);

    const Stopwatch watch;
    const auto unscaled =
        minkowski_sum_by(options.method, *a, *b, {.execution = session.execution()});
    if (!unscaled) return tl::unexpected(unscaled.error());
    const MinkowskiSum sum = unscaled->scaled(std::abs(options.scale));
    const double seconds = watch.seconds();

    std::map<FacetOrigin, std::size_t> origins;
    for (std::uint32_t f = 0; f < sum.facet_count(); ++f) ++origins[sum.facet(f).origin];
    Box bounds;
    for (std::uint32_t v = 0; v < sum.point_count(); ++v) bounds.extend(sum.position(v));
    if (!bounds.lower.allFinite() || !bounds.upper.allFinite()) {
        return fail(ErrorCode::limit_exceeded,
                    "the sum has coordinates beyond the largest double, about 1.8e308: take a "
                    "smaller scale",
                    "--scale");
    }
    CountedMethods counted;
    if (options.count_operations) {
        auto counts = count_methods(*a, *b, session);
        if (!counts) return tl::unexpected(counts.error());
        counted = std::move(*counts);
    }
    if (!options.out.empty()) {
        if (Status status =
                export_sum(sum, options.out, {.execution = {.progress = &session.progress()}});
            !status)
            return status;
    }

    TextTable table({"", "Vertices", "Edges", "Facets"});
    const auto row = [&](const std::string& name, const auto& body) {
        table.add_row({name, to_text(body.vertex_count()), to_text(body.edges().size()),
                       to_text(body.facet_count())});
    };
    row(options.models[0], *a);
    row(options.models[1], *b);
    row("sum", sum);
    session.print(table.text());
    session.print(
        fmt::format("facets of A {}, of B {}, of both {}, swept {}; V - E + F = {}\n"
                    "from ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g}); {} in {:.3g} ms\n",
                    origins[FacetOrigin::a], origins[FacetOrigin::b], origins[FacetOrigin::both],
                    origins[FacetOrigin::swept],
                    static_cast<std::int64_t>(sum.vertex_count()) -
                        static_cast<std::int64_t>(sum.edges().size()) +
                        static_cast<std::int64_t>(sum.facet_count()),
                    bounds.lower.x(), bounds.lower.y(), bounds.lower.z(), bounds.upper.x(),
                    bounds.upper.y(), bounds.upper.z(), name_of(options.method), 1e3 * seconds));
    session.print(counted.text);

    Json json = {{"a", json_of(*a, options.models[0])},
                 {"b", json_of(*b, options.models[1])},
                 {"method", name_of(options.method)},
                 {"scale", options.scale},
                 {"vertices", sum.vertex_count()},
                 {"edges", sum.edges().size()},
                 {"facets", sum.facet_count()},
                 {"facets_of_a", origins[FacetOrigin::a]},
                 {"facets_of_b", origins[FacetOrigin::b]},
                 {"facets_of_both", origins[FacetOrigin::both]},
                 {"facets_swept", origins[FacetOrigin::swept]},
                 {"lower", {bounds.lower.x(), bounds.lower.y(), bounds.lower.z()}},
                 {"upper", {bounds.upper.x(), bounds.upper.y(), bounds.upper.z()}},
                 {"seconds", seconds}};
    if (options.count_operations) json["operations"] = counted.json;
    return session.write_json(json);
}

} // namespace

Command add_minkowski_command(CLI::App& app)
{
    CLI::App* const parser =
        app.add_subcommand("minkowski", "Sum two convex models: all points a + b");
    const auto options = std::make_shared<Options>();
    for (std::size_t i = 0; i < 2; ++i) {
        parser
            ->add_option(i == 0 ? "A" : "B", options->models[i],
                         concat("A convex model: a file (", known_mesh_extensions(),
                                ") or a built-in mesh: ", sample_mesh_names()))
            ->required()
            ->type_name("");
    }
    parser
        ->add_option("--out", options->out,
                     "Write the sum, facets coloured by origin: .obj, "
                     ".ply, .glb")
        ->type_name("FILE");
    parser
        ->add_option_function<std::string>(
            "--method",
            [options](const std::string& name) {
                for (const MinkowskiMethod method : methods) {
                    if (name == name_of(method)) {
                        options->method = method;
                        return;
                    }
                }
                throw CLI::ValidationError(
                    "--method", concat(name, " is no method: they are arcs, geometric and hull"));
            },
            "arcs (the fast one, default), geometric, hull (the thesis's)")
        ->type_name("NAME");
    parser
        ->add_option(
            "--scale", options->scale,
            "Sum A and this many times B; -1 mirrors B: A + (-B) is what keeps B, moved, off A")
        ->capture_default_str()
        ->type_name("L");
    parser
        ->add_option(
            "--tolerance", options->tolerance,
            "How far a model may be from convex, as a fraction of its bounding box's diagonal")
        ->check(not_negative())
        ->capture_default_str()
        ->type_name("T");
    parser->add_flag("--hull", options->take_hull, "Sum the convex hulls of the models")
        ->excludes("--tolerance");
    parser->add_flag("--count-operations", options->count_operations,
                     "Print what each method costs in products and flops, as Table 3.2");
    parser->callback([options] {
        if (options->scale == 0 || !std::isfinite(options->scale))
            throw CLI::ValidationError("--scale", "must be a finite number other than zero");
    });
    return {parser, [options](Session& session) { return run_minkowski(*options, session); }};
}

} // namespace proxima
