// proxima proximity --method general: the proximity octree of any mesh, what queries of it cost at
// most, and the lengths of its lists.
#include "base/text.h"
#include "cli/list_histogram.h"
#include "cli/model_options.h"
#include "cli/peak_memory.h"
#include "cli/proximity_command_options.h"
#include "cli/query_timing.h"
#include "cli/stopwatch.h"
#include "cli/text_table.h"
#include "index/index_parts.h"
#include "index/lists/export_proximity.h"
#include "index/lists/proximity_lists.h"
#include "proxima/index_io.h"
#include "proxima/mesh_index.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <optional>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

/// Lists of one depth, counted and tried.
struct GeneralRow {
    int depth = 0;
    double seconds = 0;
    std::uint64_t bytes = 0;
    std::optional<std::uint64_t> peak_bytes; ///< rise of the process' memory while building
    ProximityStatistics counts;
    QueryTiming timing;
    ListStatistics lists; ///< by volume; without cells where no histogram wants them
};

std::uint64_t budget_of(const ProximityCommandOptions& options, const TriangleMesh& mesh)
{
    return options.lists_mb != 0 ? options.lists_mb * 1'000'000
                                 : default_list_bytes(mesh.triangle_count());
}

/// To --save and --out.
Status write_index(const ProximityCommandOptions& options, const MeshIndex& index, Session& session)
{
    Progress* const progress = &session.progress();
    if (!options.save.empty()) {
        Status status = save_index(index, options.save, {.execution = {.progress = progress}});
        if (!status) return status;
        session.print(fmt::format("wrote {}\n", options.save));
    }
    for (const std::string& path : options.outs) {
        Status status =
            export_proximity(*index.parts().lists(), path, {.execution = {.progress = progress}});
        if (!status) return status;
        session.print(fmt::format("wrote {}\n", path));
    }
    return {};
}

Result<std::vector<GeneralRow>> build_rows(const ProximityCommandOptions& options,
                                           const TriangleMesh& mesh, Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    Progress* const progress = &session.progress();
    const auto plain =
        build_mesh_index(mesh, {.execution = {.threads = session.threads(), .progress = progress}});
    if (!plain) return tl::unexpected(plain.error());
    std::vector<Vec3> queries; // not before a build found the mesh to be one
    std::vector<GeneralRow> rows;
    for (const int depth : options.depths) {
        const PeakMemory memory;
        const Stopwatch watch;
        const auto index =
            with_lists(*plain, {.list_bytes = budget_of(options, mesh),
                                .margin = options.margin,
                                .max_depth = depth,
                                .execution = {.threads = session.threads(), .progress = progress}});
        if (!index) return tl::unexpected(index.error());
        const ProximityLists& built = *index->parts().lists();
        GeneralRow row;
        row.depth = depth;
        row.seconds = watch.seconds();
        row.bytes = built.bytes();
        row.peak_bytes = memory.bytes();
        row.counts = built.statistics();
        if (queries.empty()) queries = estimate_queries(mesh);
        row.timing = time_queries(*index, queries);
        if (!options.histograms.empty()) {
            const LeafLists lists = list_lengths(built);
            row.lists = list_statistics(lists.lengths, lists.volumes);
        }
        rows.push_back(std::move(row));
        if (Status status = session.check_running(); !status) return tl::unexpected(status.error());
        if (Status status = write_index(options, *index, session); !status)
            return tl::unexpected(status.error());
    }
    return rows;
}

Json json_of(const GeneralRow& row)
{
    Json peak; // null where nobody knows
    if (row.peak_bytes) peak = *row.peak_bytes;
    return {{"nodes", row.counts.nodes},
            {"references", row.counts.references},
            {"bytes", row.bytes},
            {"seconds", row.seconds},
            {"max_depth", row.counts.max_depth},
            {"max_list", row.counts.max_list},
            {"mean_list", row.counts.mean_list},
            {"worst_case_steps", row.counts.worst_case_steps},
            {"worst_case_blocks", row.counts.worst_case_blocks},
            {"expected_list", row.counts.expected_list},
            {"blocks", row.counts.blocks},
            {"leaves", row.counts.leaves},
            {"searched_leaves", row.counts.searched_leaves},
            {"query_ns_median", row.timing.median},
            {"query_ns_max", row.timing.max},
            {"peak_bytes", peak}};
}

/// What all rows have in common; the figures themselves where there is but one.
Json result_of(const ProximityCommandOptions& options, const TriangleMesh& mesh,
               const std::vector<GeneralRow>& rows)
{
    Json result = {{"model", options.model},
                   {"triangles", mesh.triangle_count()},
                   {"method", "general"},
                   {"margin", options.margin},
                   {"budget_bytes", budget_of(options, mesh)}};
    if (rows.size() == 1) {
        result["depth"] = rows[0].depth;
        result.update(json_of(rows[0]));
        return result;
    }
    result["rows"] = Json::array();
    for (const GeneralRow& row : rows) {
        Json line = {{"depth", row.depth}};
        line.update(json_of(row));
        result["rows"].push_back(std::move(line));
    }
    return result;
}

std::string text_of(const std::vector<GeneralRow>& rows)
{
    TextTable table({"Depth", "Nodes", "Leaves", "References", "Mean list", "Expected", "Longest",
                     "Blocks", "MB", "Seconds", "Steps", "Blocks at most", "ns", "ns at most"});
    for (const GeneralRow& row : rows) {
        const ProximityStatistics& counts = row.counts;
        table.add_row({to_text(row.depth), to_text(counts.nodes), to_text(counts.leaves),
                       to_text(counts.references), fmt::format("{:.2f}", counts.mean_list),
                       fmt::format("{:.2f}", counts.expected_list), to_text(counts.max_list),
                       to_text(counts.blocks),
                       fmt::format("{:.2f}", 1e-6 * static_cast<double>(row.bytes)),
                       fmt::format("{:.3f}", row.seconds), to_text(counts.worst_case_steps),
                       to_text(counts.worst_case_blocks), fmt::format("{:.0f}", row.timing.median),
                       fmt::format("{:.0f}", row.timing.max)});
    }
    return table.text();
}

/// The worst case of the deepest octree in words.
std::string promise_of(const GeneralRow& row)
{
    const ProximityStatistics& counts = row.counts;
    const auto many = [](std::uint32_t count, const char* what) {
        return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
    };
    std::string searched;
    if (counts.searched_leaves != 0) {
        searched = fmt::format("In {} of {} leaves, which have no list, it searches the tree.\n",
                               counts.searched_leaves, counts.leaves);
    }
    return fmt::format(
        "A query in the root takes at most {} down and {} of triangles.\n{}"
        "About {:.0f} ns, {:.0f} ns at most: estimated from {} queries timed here one by one\n",
        many(counts.worst_case_steps, "step"), many(counts.worst_case_blocks, "block"), searched,
        row.timing.median, row.timing.max, row.timing.queries);
}

std::string peak_of(const GeneralRow& row, std::uint64_t budget)
{
    if (!row.peak_bytes) return {};
    const auto peak = static_cast<double>(*row.peak_bytes);
    return fmt::format("Building raised the memory of the process by {:.2f} MB at most, {:.2f} "
                       "times the budget\n",
                       1e-6 * peak, peak / static_cast<double>(budget));
}

} // namespace

Status run_general_proximity(const ProximityCommandOptions& options, Session& session)
{
    const auto mesh = session.load_model(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto rows = build_rows(options, *mesh, session);
    if (!rows) return at_model(rows.error(), options.model);

    const std::string how =
        fmt::format("root {:g} times the tight cube, budget {:.6g} MB", 1 + options.margin,
                    1e-6 * static_cast<double>(budget_of(options, *mesh)));
    session.print(fmt::format("Proximity octree of {}, {} triangles\n{}\n\n{}\n{}{}", options.model,
                              mesh->triangle_count(), how, text_of(*rows), promise_of(rows->back()),
                              peak_of(rows->back(), budget_of(options, *mesh))));

    std::vector<HistogramSeries> series;
    for (const GeneralRow& row : *rows) series.push_back({row.depth, row.lists});
    const HistogramTitle title = {concat("Triangles that leaves of ", options.model, " list"), how};
    for (const std::string& path : options.histograms) {
        Status status =
            write_histogram(series, HistogramOf::leaves, title, path, &session.progress());
        if (!status) return status;
        session.print(fmt::format("wrote {}\n", path));
    }
    return session.write_json(result_of(options, *mesh, *rows));
}

} // namespace proxima
