// proxima proximity --method thesis: the thesis's proximity octree of a convex model, and the
// lengths of its lists (thesis 5.1.2, figure 5.3).
#include "base/text.h"
#include "cli/list_histogram.h"
#include "cli/model_options.h"
#include "cli/proximity_command_options.h"
#include "cli/stopwatch.h"
#include "cli/text_table.h"
#include "thesis/proximity_octree/convex_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

/// One octree, counted.
struct ThesisRow {
    int depth = 0;
    double seconds = 0;
    std::size_t nodes = 0;
    std::size_t references = 0;
    std::uint64_t bytes = 0;
    int depth_reached = 0;
    std::array<std::uint64_t, 3> leaves_by_type = {};
    ListStatistics lists; ///< of outer and boundary leaves
    ListStatistics outer; ///< of leaves outside the circumscribed sphere

    [[nodiscard]] std::uint64_t leaves(CellClass type) const
    {
        return leaves_by_type[static_cast<std::size_t>(type)];
    }
};

ThesisRow count(const ThesisProximityOctree& octree, const MeshSphere& sphere)
{
    ThesisRow row;
    row.nodes = octree.node_count();
    row.references = octree.reference_count();
    row.bytes = octree.bytes();
    row.depth_reached = octree.depth_reached();
    std::vector<std::uint32_t> lengths;
    for (const ThesisLeaf& leaf : octree.leaves()) {
        ++row.leaves_by_type[static_cast<std::size_t>(leaf.type)];
        if (leaf.type == CellClass::inner) continue;
        lengths.push_back(leaf.closest[0] + leaf.closest[1] + leaf.closest[2]);
    }
    row.lists = list_statistics(lengths);
    row.outer = list_statistics(outer_list_lengths(octree, sphere));
    return row;
}

/// The sine of the angle whose 1 - cos is --flat's.
double flat_sine(const ProximityCommandOptions& options)
{
    if (!(options.flat > 0)) return ThesisProximityOptions{}.flat_sine;
    return std::sqrt(options.flat * (2 - options.flat));
}

/// How many edges have a region: the thesis's non-degenerate ones. \pre the mesh is convex
Result<std::size_t> count_ridges(const ProximityCommandOptions& options, const TriangleMesh& mesh,
                                 Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    const auto topology = build_topology(mesh, {.execution = session.execution()});
    if (!topology) return tl::unexpected(topology.error());
    const auto surface = check_convex_surface(
        mesh, *topology, {.flat_sine = flat_sine(options), .execution = session.execution()});
    if (!surface) return tl::unexpected(surface.error());
    return static_cast<std::size_t>(std::ranges::count(surface->folds, EdgeFold::ridge));
}

Result<std::vector<ThesisRow>> build_thesis_rows(const ProximityCommandOptions& options,
                                                 const TriangleMesh& mesh, Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    Progress* const progress = &session.progress();
    const MemoryBudget budget = {options.budget_mb * 1'000'000};
    const auto topology = build_topology(
        mesh,
        {.execution = {.threads = session.threads(), .progress = progress, .budget = budget}});
    if (!topology) return tl::unexpected(topology.error());
    std::vector<ThesisRow> rows;
    for (const int depth : options.depths) {
        const Stopwatch watch;
        const auto octree = build_thesis_proximity_octree(
            mesh, *topology,
            {.max_depth = depth,
             .thresholds = options.thresholds,
             .margin = options.margin,
             .flat_sine = flat_sine(options),
             .execution = {.threads = session.threads(), .progress = progress, .budget = budget}});
        const double seconds = watch.seconds();
        if (!octree) return tl::unexpected(octree.error());
        rows.push_back(count(*octree, circumscribed_sphere(mesh)));
        rows.back().depth = depth;
        rows.back().seconds = seconds;
    }
    return rows;
}

Json json_of(const ThesisRow& row)
{
    // Lists are not cut into blocks.
    return {{"nodes", row.nodes},
            {"references", row.references},
            {"bytes", row.bytes},
            {"seconds", row.seconds},
            {"max_depth", row.depth_reached},
            {"max_list", row.lists.max},
            {"mean_list", row.lists.mean},
            {"worst_case_steps", row.depth_reached},
            {"worst_case_blocks", nullptr},
            {"inner", row.leaves(CellClass::inner)},
            {"outer", row.leaves(CellClass::outer)},
            {"boundary", row.leaves(CellClass::boundary)},
            {"outer_cells", row.outer.cells},
            {"outer_max_list", row.outer.max},
            {"outer_mean_list", row.outer.mean},
            {"outer_percent_up_to_16", 100 * row.outer.share_up_to(16)}};
}

std::string text_of(const std::vector<ThesisRow>& rows)
{
    TextTable table({"Depth", "Nodes", "Inner", "Outer", "Boundary", "References", "Mean list",
                     "Longest", "Outer cells", "Mean list", "Longest", "To 16 %", "MB", "Seconds"});
    for (const ThesisRow& row : rows) {
        const bool any = row.outer.cells > 0;
        table.add_row({to_text(row.depth), to_text(row.nodes),
                       to_text(row.leaves(CellClass::inner)), to_text(row.leaves(CellClass::outer)),
                       to_text(row.leaves(CellClass::boundary)), to_text(row.references),
                       fmt::format("{:.2f}", row.lists.mean), to_text(row.lists.max),
                       to_text(row.outer.cells), any ? fmt::format("{:.2f}", row.outer.mean) : "",
                       any ? to_text(row.outer.max) : "",
                       any ? fmt::format("{:.1f}", 100 * row.outer.share_up_to(16)) : "",
                       fmt::format("{:.2f}", 1e-6 * static_cast<double>(row.bytes)),
                       fmt::format("{:.3f}", row.seconds)});
    }
    return table.text();
}

/// What all rows have in common; the figures themselves where there is but one.
Json result_of(const ProximityCommandOptions& options, const TriangleMesh& mesh,
               const std::vector<ThesisRow>& rows)
{
    Json result = {{"model", options.model},
                   {"triangles", mesh.triangle_count()},
                   {"method", "thesis"},
                   {"threshold_vertex", options.thresholds.vertex},
                   {"threshold_edge", options.thresholds.edge},
                   {"threshold_face", options.thresholds.face},
                   {"margin", options.margin}};
    if (rows.size() == 1) {
        result["depth"] = rows[0].depth;
        result.update(json_of(rows[0]));
        return result;
    }
    result["rows"] = Json::array();
    for (const ThesisRow& row : rows) {
        Json line = {{"depth", row.depth}};
        line.update(json_of(row));
        result["rows"].push_back(std::move(line));
    }
    return result;
}

} // namespace

Status run_thesis_proximity(const ProximityCommandOptions& options, Session& session)
{
    const auto mesh = session.load_model(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto rows = build_thesis_rows(options, *mesh, session);
    if (!rows) return at_model(rows.error(), options.model);

    const auto ridges = count_ridges(options, *mesh, session);
    if (!ridges) return at_model(ridges.error(), options.model);
    const KindThresholds& thresholds = options.thresholds;
    const std::string how =
        fmt::format("root {:g} times the tight cube, thresholds {} (vertices), {} (edges), {} "
                    "(faces)",
                    1 + options.margin, thresholds.vertex, thresholds.edge, thresholds.face);
    session.print(
        fmt::format("Proximity octree as in the thesis of {}, {} triangles, {} edges that are not "
                    "flat\n{}\n\n{}\nOuter cells: leaves "
                    "outside the circumscribed sphere\n",
                    options.model, mesh->triangle_count(), *ridges, how, text_of(*rows)));

    std::vector<HistogramSeries> series;
    for (const ThesisRow& row : *rows) series.push_back({row.depth, row.outer});
    const HistogramTitle title = {concat("Features that outer cells of ", options.model, " list"),
                                  how};
    for (const std::string& path : options.histograms) {
        Status status =
            write_histogram(series, HistogramOf::outer_cells, title, path, &session.progress());
        if (!status) return status;
        session.print(fmt::format("wrote {}\n", path));
    }
    Json json = result_of(options, *mesh, *rows);
    json["ridge_edges"] = *ridges;
    return session.write_json(json);
}

} // namespace proxima
