// proxima repair: mends what needs no new geometry, says what each step did, and keeps the old ids.
#include "base/text.h"
#include "cli/commands.h"
#include "cli/counted.h"
#include "cli/model_options.h"
#include "cli/npy_header.h"
#include "cli/number_checks.h"
#include "cli/row_text.h"
#include "cli/row_writer.h"
#include "cli/stopwatch.h"
#include "cli/triangle_file.h"
#include "proxima/mesh_io.h"
#include "proxima/mesh_repair.h"
#include "proxima/mesh_report.h"

#include <CLI/CLI.hpp>
#include <array>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

struct RepairCommandOptions {
    std::string model;
    std::string out;
    std::string map;
    std::string vertex_map;
    MeshRepairOptions steps;
};

std::string text_of(const RepairStep& step)
{
    struct Words {
        std::string_view verb, noun, plural, rest;
    };
    constexpr std::array<Words, repair_step_count> words = {{
        {"dropped", "triangle", "triangles", " with a NaN or infinite corner"},
        {"welded", "vertex", "vertices", ""},
        {"dropped", "degenerate triangle", "degenerate triangles", ""},
        {"dropped", "triangle", "triangles", " without area"},
        {"dropped", "duplicate triangle", "duplicate triangles", ""},
        {"dropped", "small component", "small components", ""},
        {"turned over", "triangle", "triangles", " to match the others"},
        {"turned over", "closed piece", "closed pieces", " as a whole"},
        {"dropped", "unused vertex", "unused vertices", ""},
    }};
    const auto& [verb, noun, plural, rest] = words[static_cast<std::size_t>(step.kind)];
    return fmt::format("{} {}{}\n", verb, counted(step.count, noun, plural), rest);
}

std::uint64_t count_of(const MeshReport& report, FindingKind kind)
{
    const MeshFinding* const found = report.find(kind);
    return found == nullptr ? 0 : found->count;
}

std::string sizes_text(const std::string& name, std::uint64_t vertices, std::uint64_t triangles)
{
    return fmt::format("{}: {}, {}", name, counted(vertices, "vertex", "vertices"),
                       counted(triangles, "triangle", "triangles"));
}

/// What no step mends, and who does.
std::string left_text(const MeshRepair& repair, const MeshReport& report)
{
    std::string text;
    const auto add = [&](std::uint64_t count, std::string_view noun, std::string_view plural,
                         std::string_view advice) {
        if (count > 0) text += fmt::format("    {}: {}\n", counted(count, noun, plural), advice);
    };
    add(report.boundary_loops, "hole or open rim", "holes or open rims",
        "MeshLab, PyMeshFix, or CGAL's triangulate_hole fill holes");
    add(count_of(report, FindingKind::non_manifold_edges), "non-manifold edge",
        "non-manifold edges", "MeshLab or PyMeshFix cut surfaces that branch");
    add(count_of(report, FindingKind::non_manifold_vertices), "non-manifold vertex",
        "non-manifold vertices", "MeshLab, or CGAL's duplicate_non_manifold_vertices split them");
    add(repair.unorientable_edges, "edge", "edges",
        "of pieces with one side, as a Möbius strip has: no turning makes them match");
    return text.empty() ? text : "left for other tools:\n" + text;
}

std::string result_text(const std::string& model, const TriangleMesh& before,
                        const MeshRepair& repair, const MeshReport& report)
{
    std::string text = sizes_text(model, before.vertex_count(), before.triangle_count()) + '\n';
    for (const RepairStep& step : repair.steps)
        if (step.enabled) text += text_of(step);
    text += sizes_text("result", repair.mesh.vertex_count(), repair.mesh.triangle_count());
    text += report.closed ? ", closed" : ", open";
    text += report.consistently_oriented ? ", consistently oriented" : "";
    if (report.signed_volume) {
        text +=
            fmt::format(", {}, volume {:.6g}", name_of(report.orientation), *report.signed_volume);
    }
    if (repair.cavities > 0) text += ", " + counted(repair.cavities, "cavity", "cavities");
    return text + '\n' + left_text(repair, report) +
           "proxima check says where, and whether the surface intersects itself\n";
}

Json json_of(const std::string& model, const TriangleMesh& before, const MeshRepair& repair,
             const MeshReport& report, double seconds)
{
    Json steps = Json::array();
    for (const RepairStep& step : repair.steps) {
        steps.push_back(
            {{"step", name_of(step.kind)}, {"enabled", step.enabled}, {"count", step.count}});
    }
    return {{"model", model},
            {"vertices_before", before.vertex_count()},
            {"triangles_before", before.triangle_count()},
            {"steps", steps},
            {"vertices", report.vertices},
            {"triangles", report.triangles},
            {"components", report.components},
            {"pieces", repair.pieces},
            {"closed_pieces", repair.closed_pieces},
            {"cavities", repair.cavities},
            {"unorientable_pieces", repair.unorientable_pieces},
            {"unorientable_edges", repair.unorientable_edges},
            {"closed", report.closed},
            {"consistently_oriented", report.consistently_oriented},
            {"orientation", name_of(report.orientation)},
            {"signed_volume", report.signed_volume ? Json(*report.signed_volume) : Json()},
            {"boundary_loops", report.boundary_loops},
            {"non_manifold_edges", count_of(report, FindingKind::non_manifold_edges)},
            {"non_manifold_vertices", count_of(report, FindingKind::non_manifold_vertices)},
            {"seconds", seconds}};
}

Status check_map(const std::string& path)
{
    if (path.empty()) return {};
    const auto format = answer_format(path);
    return format ? Status{} : tl::unexpected(format.error());
}

/// A table of numbers, a row per item: row(i) returns them.
template <class Row>
Status write_map(const std::string& path, std::string_view columns, std::size_t count,
                 const Session& session, const Row& row)
{
    constexpr std::size_t rows_per_task = 8192;
    auto file = RowWriter::open(path);
    if (!file) return tl::unexpected(file.error());
    if (!file->is_wanted()) return {};
    const AnswerFormat format = file->format();
    const std::string header = format == AnswerFormat::npy
                                   ? npy_header(count, std::tuple_size_v<decltype(row(0))>)
                                   : concat(columns, "\n");
    if (Status status = file->write(header); !status) return status;
    const auto rows = [&](std::size_t first, std::size_t end) {
        fmt::memory_buffer text;
        for (std::size_t i = first; i < end; ++i) append_row(text, format, row(i));
        return fmt::to_string(text);
    };
    if (Status status = file->write_chunks(count, rows_per_task, session.threads(), rows); !status)
        return status;
    return file->commit();
}

Status write_files(const RepairCommandOptions& options, const MeshRepair& repair, Session& session)
{
    if (!options.out.empty()) {
        Status written = write_mesh(repair.mesh, options.out, {.execution = session.execution()});
        if (!written) return written;
    }
    Status written =
        write_map(options.map, "triangle,original,turned", repair.original_triangles.size(),
                  session, [&](std::size_t i) {
                      return std::array{static_cast<double>(i),
                                        static_cast<double>(to_index(repair.original_triangles[i])),
                                        static_cast<double>(repair.turned[i])};
                  });
    if (!written) return written;
    return write_map(options.vertex_map, "vertex,original", repair.original_vertices.size(),
                     session, [&](std::size_t i) {
                         return std::array{
                             static_cast<double>(i),
                             static_cast<double>(to_index(repair.original_vertices[i]))};
                     });
}

Status check_files(const RepairCommandOptions& options, Session& session)
{
    Status outputs = session.check_outputs({options.out, options.map, options.vertex_map});
    if (!outputs) return outputs;
    if (!options.out.empty()) {
        if (Status status = check_mesh_file_format(options.out); !status) return status;
    }
    if (Status status = check_map(options.map); !status) return status;
    return check_map(options.vertex_map);
}

Status run_repair(const RepairCommandOptions& options, Session& session)
{
    if (Status status = check_files(options, session); !status) return status;
    const auto mesh = session.load_model(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    const ProgressBar shown(session.progress(), session.bar());
    MeshRepairOptions steps = options.steps;
    steps.execution = session.execution();
    const Stopwatch watch;
    const auto repair = repair_mesh(*mesh, steps);
    if (!repair) return at_model(repair.error(), options.model);
    const double seconds = watch.seconds();
    const auto report = report_mesh(repair->mesh, {.execution = session.execution()});
    if (!report) return at_model(report.error(), options.model);
    if (Status status = write_files(options, *repair, session); !status) return status;
    session.print(result_text(options.model, *mesh, *repair, *report));
    return session.write_json(json_of(options.model, *mesh, *repair, *report, seconds));
}

void add_file_options(CLI::App& parser, RepairCommandOptions& options)
{
    parser
        .add_option(
            "--out", options.out,
            "Write the repaired mesh: .obj, .ply, .off, .stl; without it nothing is written")
        ->type_name("FILE");
    parser
        .add_option("--map", options.map,
                    "Write where its triangles come from: .csv or .npy of triangle,original,turned")
        ->type_name("FILE");
    parser
        .add_option("--vertex-map", options.vertex_map,
                    "Write where its vertices come from: .csv or .npy of vertex,original")
        ->type_name("FILE");
}

void add_step_options(CLI::App& parser, MeshRepairOptions& steps)
{
    const auto off = [&](const char* name, bool& step, const char* description) {
        return parser.add_flag_callback(
            name, [&step] { step = false; }, description);
    };
    off("--keep-non-finite", steps.drop_non_finite, "Keep triangles with a NaN or infinite corner");
    CLI::Option* const no_weld = off("--no-weld", steps.weld, "Join no vertices");
    parser
        .add_option("--weld", steps.weld_distance,
                    "Join vertices up to this far apart, in the model's unit; 0, the default: at "
                    "the same position")
        ->check(number_between(0.0, 1e300))
        ->type_name("DISTANCE")
        ->excludes(no_weld);
    off("--keep-degenerate", steps.drop_degenerate, "Keep triangles that name a vertex twice");
    parser.add_flag(
        "--drop-zero-area", steps.drop_zero_area,
        "Drop triangles whose three vertices lie exactly on one line; this opens slits");
    off("--keep-duplicates", steps.drop_duplicates,
        "Keep triangles of the same three vertices as an earlier one");
    parser
        .add_option("--min-component-area", steps.min_component_area,
                    "Drop components of less than this fraction of the largest one's area")
        ->check(number_between(0.0, 1.0))
        ->capture_default_str()
        ->type_name("F");
    parser
        .add_option("--min-component-triangles", steps.min_component_triangles,
                    "Drop components of fewer triangles")
        ->capture_default_str()
        ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 32U))
        ->type_name("N");
    off("--no-orient", steps.orient, "Do not turn triangles over to match their neighbours");
    off("--no-outward", steps.turn_outward, "Do not turn closed pieces outward");
    off("--no-cavities", steps.keep_cavities,
        "Turn closed pieces outward even inside others: they are solids, not cavities")
        ->excludes("--no-outward");
    off("--keep-unused", steps.drop_unused_vertices, "Keep vertices that no triangle uses");
}

} // namespace

Command add_repair_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "repair", "Weld vertices, drop flawed triangles, turn the rest to face outward");
    const auto options = std::make_shared<RepairCommandOptions>();
    add_model_option(*parser, options->model);
    add_file_options(*parser, *options);
    add_step_options(*parser, options->steps);
    return {parser, [options](Session& session) { return run_repair(*options, session); }};
}

} // namespace proxima
