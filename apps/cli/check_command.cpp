// proxima check: what is wrong with a mesh, where, and what still works; whether an octree file is
// sound.
#include "base/text.h"
#include "cli/check_index_file.h"
#include "cli/check_octree_file.h"
#include "cli/commands.h"
#include "cli/counted.h"
#include "cli/index_file_model.h"
#include "cli/json_numbers.h"
#include "cli/model_options.h"
#include "cli/octree_file_model.h"
#include "cli/text_table.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_report.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

struct CheckOptions {
    std::string model;
    std::string mesh; ///< of an octree file, may be empty
    bool strict = false;
};

template <class T>
Json json_of(const std::optional<T>& value)
{
    return value ? Json(*value) : Json();
}

Json json_of(const MeshFinding& finding)
{
    Json positions = Json::array();
    for (const Vec3& position : finding.first_positions)
        positions.push_back(json_numbers(position));
    return {{"kind", name_of(finding.kind)},       {"severity", name_of(finding.severity)},
            {"element", name_of(finding.element)}, {"count", finding.count},
            {"first_ids", finding.first_ids},      {"first_positions", positions},
            {"meaning", finding.meaning}};
}

/// How many pairs are shown.
constexpr std::size_t first_pairs = 5;

Json json_of(const SelfIntersections& found)
{
    Json first = Json::array();
    for (std::size_t i = 0; i < std::min(first_pairs, found.pairs.size()); ++i)
        first.push_back({to_index(found.pairs[i].a), to_index(found.pairs[i].b)});
    return {{"pairs", found.pairs.size()}, {"complete", found.complete}, {"first_pairs", first}};
}

Json json_of(const MeshReport& report, const std::optional<SelfIntersections>& intersections,
             const std::string& model)
{
    Json bounds;
    if (!report.bounds.empty()) {
        bounds = {{"lower", json_numbers(report.bounds.lower)},
                  {"upper", json_numbers(report.bounds.upper)}};
    }
    Json findings = Json::array();
    for (const MeshFinding& finding : report.findings) findings.push_back(json_of(finding));
    Json outlook = Json::array();
    for (const QueryOutlook& query : report.outlook) {
        outlook.push_back({{"query", name_of(query.query)},
                           {"outlook", name_of(query.outlook)},
                           {"reason", query.reason}});
    }
    return {{"model", model},
            {"vertices", report.vertices},
            {"triangles", report.triangles},
            {"edges", report.edges},
            {"components", report.components},
            {"boundary_loops", report.boundary_loops},
            {"bounds", bounds},
            {"area", report.area},
            {"min_edge_length", report.min_edge_length},
            {"max_edge_length", report.max_edge_length},
            {"closed", report.closed},
            {"consistently_oriented", report.consistently_oriented},
            {"closed_if_welded", json_of(report.closed_if_welded)},
            {"orientation", name_of(report.orientation)},
            {"signed_volume", json_of(report.signed_volume)},
            {"euler_characteristic", report.euler_characteristic},
            {"genus", json_of(report.genus)},
            {"self_intersections", intersections ? json_of(*intersections) : Json()},
            {"findings", findings},
            {"outlook", outlook}};
}

std::string point_text(const Vec3& point)
{
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", point.x(), point.y(), point.z());
}

/// "boundary_edges" as people write it.
std::string words(std::string_view name)
{
    std::string text(name);
    for (char& letter : text) {
        if (letter == '_') letter = ' ';
    }
    return text;
}

/// "boundary edges", of one "boundary edge".
std::string words(FindingKind kind, std::uint64_t count)
{
    std::string text = words(name_of(kind));
    if (count != 1) return text;
    constexpr std::string_view vertices = "vertices";
    if (text.ends_with(vertices)) return text.replace(text.size() - vertices.size(), 8, "vertex");
    if (text.ends_with('s')) text.pop_back();
    return text;
}

std::string finding_text(const MeshFinding& finding)
{
    std::string text =
        finding.element == ElementKind::mesh
            ? words(name_of(finding.kind))
            : fmt::format("{} {}", finding.count, words(finding.kind, finding.count));
    text = fmt::format("{}: {}\n    {}\n", name_of(finding.severity), text, finding.meaning);
    if (!finding.first_ids.empty()) {
        text +=
            fmt::format("    {}:", finding.count > finding.first_ids.size() ? "the first" : "at");
        for (std::size_t i = 0; i < finding.first_ids.size(); ++i) {
            text += fmt::format("{} {} {}", i == 0 ? "" : ",", name_of(finding.element),
                                finding.first_ids[i]);
            if (i < finding.first_positions.size())
                text += ' ' + point_text(finding.first_positions[i]);
        }
        text += '\n';
    }
    return text;
}

std::string intersections_text(const SelfIntersections& found)
{
    std::string text = fmt::format(
        "warning: {}{} intersect\n    triangles that meet in more than the corners they share: "
        "where the surface passes through itself or folds back, inside and outside mean less\n    "
        "{}:",
        found.complete ? "" : "at least ",
        counted(found.pairs.size(), "pair of triangles", "pairs of triangles"),
        found.pairs.size() > first_pairs ? "the first" : "at");
    for (std::size_t i = 0; i < std::min(first_pairs, found.pairs.size()); ++i) {
        text += fmt::format("{} {} and {}", i == 0 ? "" : ",", to_index(found.pairs[i].a),
                            to_index(found.pairs[i].b));
    }
    return text + '\n';
}

std::string report_text(const MeshReport& report,
                        const std::optional<SelfIntersections>& intersections,
                        const std::string& model)
{
    std::string text = fmt::format(
        "{}: {}, {}, {}, {}\n", model, counted(report.vertices, "vertex", "vertices"),
        counted(report.triangles, "triangle", "triangles"), counted(report.edges, "edge", "edges"),
        counted(report.components, "component", "components"));
    if (!report.bounds.empty()) {
        text += fmt::format("from {} to {}, area {:.6g}, edges {:.3g} to {:.3g} long\n",
                            point_text(report.bounds.lower), point_text(report.bounds.upper),
                            report.area, report.min_edge_length, report.max_edge_length);
    }
    text += report.closed
                ? std::string("closed")
                : "open, " + counted(report.boundary_loops, "boundary loop", "boundary loops");
    text +=
        report.consistently_oriented ? ", consistently oriented" : ", not consistently oriented";
    if (report.signed_volume) {
        text +=
            fmt::format(", {}, volume {:.6g}", name_of(report.orientation), *report.signed_volume);
    }
    if (report.genus) text += fmt::format(", genus {}", *report.genus);
    text += fmt::format(", Euler characteristic {}\n", report.euler_characteristic);
    if (report.closed_if_welded.value_or(false)) {
        text += "it would be closed if vertices at the same position were one\n";
    }
    text += '\n';
    const bool intersects = intersections && !intersections->pairs.empty();
    if (report.findings.empty() && !intersects) text += "nothing is wrong with it\n";
    for (const MeshFinding& finding : report.findings) text += finding_text(finding);
    if (intersects) text += intersections_text(*intersections);

    TextTable outlook({"Query", "Outlook", "Why"});
    for (const QueryOutlook& query : report.outlook) {
        outlook.add_row({words(name_of(query.query)), words(name_of(query.outlook)), query.reason});
    }
    return text + '\n' + outlook.text();
}

/// Nothing of a mesh that builders refuse.
Result<std::optional<SelfIntersections>> intersections_of(const TriangleMesh& mesh,
                                                          Session& session)
{
    if (!checked_bounding_box(mesh)) return std::nullopt;
    Progress* const progress = &session.progress();
    const ProgressBar shown(session.progress(), session.bar());
    const auto index =
        build_mesh_index(mesh, {.execution = {.threads = session.threads(), .progress = progress}});
    if (!index) return tl::unexpected(index.error());
    auto found = find_self_intersections(
        *index, {.execution = {.threads = session.threads(), .progress = progress}});
    if (!found) return tl::unexpected(found.error());
    return std::move(*found);
}

/// Signs heed it: surface_sides.h.
void look_again(MeshReport& report, const SelfIntersections& intersections)
{
    if (intersections.pairs.empty()) return;
    for (QueryOutlook& query : report.outlook) {
        if (query.query != QueryKind::sign || query.outlook != Outlook::works) continue;
        query.outlook = Outlook::with_care;
        query.reason = "winding numbers decide beside triangles that pass through each other; "
                       "where sheets overlap, inside is where the number is at least 1/2";
    }
}

/// Error invalid_mesh where something is wrong with a mesh.
Status check_sound(const MeshReport& report, const std::optional<SelfIntersections>& intersections,
                   const std::string& model)
{
    const auto wrong = std::ranges::count_if(report.findings, [](const MeshFinding& finding) {
        return finding.severity != Severity::note;
    });
    const bool intersects = intersections && !intersections->pairs.empty();
    const std::ptrdiff_t all = wrong + (intersects ? 1 : 0);
    if (all == 0) return {};
    return fail(ErrorCode::invalid_mesh,
                concat("has ", all, all == 1 ? " flaw" : " flaws",
                       " (warnings and errors of proxima check)"),
                model);
}

Status check_mesh(const std::string& model, bool strict, Session& session)
{
    const auto mesh = session.load_model(model);
    if (!mesh) return tl::unexpected(mesh.error());
    auto report = [&] {
        const ProgressBar shown(session.progress(), session.bar());
        return report_mesh(*mesh, {.execution = session.execution()});
    }();
    if (!report) return at_model(report.error(), model);
    const auto intersections = intersections_of(*mesh, session);
    if (!intersections) return at_model(intersections.error(), model);
    if (*intersections) look_again(*report, **intersections);
    session.print(report_text(*report, *intersections, model));
    if (Status status = session.write_json(json_of(*report, *intersections, model)); !status)
        return status;
    return strict ? check_sound(*report, *intersections, model) : Status();
}

} // namespace

Command add_check_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "check", "Report what is wrong with a mesh, a saved octree or a saved index");
    const auto options = std::make_shared<CheckOptions>();
    constexpr ModelKinds kinds = ModelKinds::meshes_octrees_and_indexes;
    add_model_option(*parser, options->model, kinds);
    add_mesh_option(*parser, options->model, kinds, options->mesh, {});
    parser->add_flag("--strict", options->strict,
                     "Exit with status 1 where a mesh has warnings or errors");
    parser->final_callback([options] {
        if (options->strict && (is_octree_file(options->model) || is_index_file(options->model))) {
            throw CLI::ValidationError(
                "--strict",
                "is about meshes: leave it out, a saved octree or index that is not sound "
                "gives status 1 without it");
        }
    });
    return {parser, [options](Session& session) {
                if (is_octree_file(options->model))
                    return check_octree_file(options->model, options->mesh, session);
                if (is_index_file(options->model))
                    return check_index_file(options->model, options->mesh, session);
                return check_mesh(options->model, options->strict, session);
            }};
}

} // namespace proxima
