// proxima proximity --budget-curve: how quick queries are by the budget that the octree was built
// with.
#include "base/text.h"
#include "cli/model_options.h"
#include "cli/plot.h"
#include "cli/proximity_command_options.h"
#include "cli/query_timing.h"
#include "cli/stopwatch.h"
#include "cli/text_table.h"
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "lab/query_sets.h"
#include "proxima/mesh_index.h"

#include <array>
#include <filesystem>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

/// Bytes per triangle.
constexpr std::array<std::uint64_t, 12> curve_budgets = {100, 150,  200,  300,  400,  600,
                                                         900, 1500, 2500, 4000, 7000, 12000};
constexpr std::size_t queries_per_set = 100'000;
constexpr std::array set_names = {"a: in 1.2 times the box", "b: surface +- 1 % of the diagonal",
                                  "c: a walk near the surface"};

struct CurveRow {
    std::uint64_t budget = 0; ///< bytes per triangle, as those of the lists are
    double bytes = 0;
    double seconds = 0;             ///< of the build
    std::array<double, 3> ns = {};  ///< per query of the sets a, b, c
    std::uint32_t worst_blocks = 0; ///< of a query in the root
};

struct Curve {
    std::vector<CurveRow> rows;
    std::vector<std::uint64_t> left_out; ///< budgets that are too small for any lists
    std::optional<std::uint64_t> enough; ///< no larger budget makes other lists
};

/// Builds with one budget after the other.
class CurveRun {
public:
    CurveRun(const ProximityCommandOptions& options, const TriangleMesh& mesh,
             const MeshIndex& index, Session& session)
        : options_(options), mesh_(mesh), index_(index), session_(session)
    {}

    /// The largest budget first: where a smaller one gives the same octree, the rest need no try.
    Result<Curve> run()
    {
        const auto largest = try_budget(curve_budgets.back());
        if (!largest) return tl::unexpected(largest.error());
        Curve curve;
        for (const std::uint64_t budget :
             std::span(curve_budgets).first<curve_budgets.size() - 1>()) {
            const auto row = try_budget(budget);
            if (!row && row.error().code == ErrorCode::budget_exceeded) {
                curve.left_out.push_back(budget);
                continue;
            }
            if (!row) return tl::unexpected(row.error());
            curve.rows.push_back(*row);
            if (row->bytes == largest->bytes) {
                curve.enough = budget;
                return curve;
            }
        }
        curve.rows.push_back(*largest);
        return curve;
    }

private:
    Result<CurveRow> try_budget(std::uint64_t budget)
    {
        const ProgressBar shown(session_.progress(), session_.bar());
        const Stopwatch watch;
        const std::size_t triangles = mesh_.triangle_count();
        const auto index = with_lists(index_, {.list_bytes = budget * triangles,
                                               .margin = options_.margin,
                                               .max_depth = options_.depths.back(),
                                               .execution = session_.execution()});
        if (!index) return tl::unexpected(index.error());
        CurveRow row;
        row.budget = budget;
        row.seconds = watch.seconds();
        row.bytes =
            static_cast<double>(index->parts().lists()->bytes()) / static_cast<double>(triangles);
        row.worst_blocks = index->parts().lists()->statistics().worst_case_blocks;
        // Not before a build found the mesh to be one.
        if (!sets_) sets_ = query_sets(mesh_, queries_per_set, 1);
        for (std::size_t i = 0; i < sets_->size(); ++i)
            row.ns[i] = time_pass(*index, (*sets_)[i].points);
        if (Status status = session_.check_running(); !status)
            return tl::unexpected(status.error());
        return row;
    }

    const ProximityCommandOptions& options_;
    const TriangleMesh& mesh_;
    const MeshIndex& index_;
    Session& session_;
    std::optional<std::array<QuerySet, 3>> sets_;
};

/// Why some budgets are not in the curve.
std::vector<std::string> notes_of(const Curve& curve)
{
    std::vector<std::string> notes;
    std::string list;
    for (const std::uint64_t budget : curve.left_out)
        list += concat(list.empty() ? "" : ", ", budget);
    if (!list.empty()) {
        notes.push_back(fmt::format(
            "left out, for they are too small for any lists: {} bytes per triangle", list));
    }
    if (curve.enough) {
        notes.push_back(fmt::format(
            "budgets of more than {} bytes per triangle give the same lists", *curve.enough));
    }
    return notes;
}

std::string text_of(const Curve& curve)
{
    TextTable table({"Budget", "Bytes", "Seconds", "ns a", "ns b", "ns c", "Blocks at most"});
    for (const CurveRow& row : curve.rows) {
        table.add_row({to_text(row.budget), fmt::format("{:.1f}", row.bytes),
                       fmt::format("{:.3f}", row.seconds), fmt::format("{:.0f}", row.ns[0]),
                       fmt::format("{:.0f}", row.ns[1]), fmt::format("{:.0f}", row.ns[2]),
                       to_text(row.worst_blocks)});
    }
    std::string text = table.text();
    for (const std::string& note : notes_of(curve)) text += note + '\n';
    return text;
}

std::string csv_of(const Curve& curve)
{
    std::string csv = "budget_bytes_per_triangle,bytes_per_triangle,seconds,ns_a,ns_b,ns_c\n";
    for (const CurveRow& row : curve.rows) {
        csv += fmt::format("{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", row.budget, row.bytes,
                           row.seconds, row.ns[0], row.ns[1], row.ns[2]);
    }
    return csv;
}

Figure figure_of(const Curve& curve, const std::string& model, std::size_t triangles)
{
    std::vector<PlotSeries> series;
    for (std::size_t i = 0; i < set_names.size(); ++i) {
        PlotSeries one{set_names[i], {}};
        for (const CurveRow& row : curve.rows) one.points.emplace_back(row.bytes, row.ns[i]);
        series.push_back(std::move(one));
    }
    PlotWords words{concat("The closest feature of ",
                           std::filesystem::path(model).filename().string(),
                           " by the size of its lists"),
                    {fmt::format("{} triangles; one thread, single queries, {} of each set, "
                                 "median of five rounds",
                                 triangles, queries_per_set)},
                    "bytes of the lists per triangle",
                    "nanoseconds per query"};
    for (std::string& note : notes_of(curve)) words.notes.push_back(std::move(note));
    return log_plot(series, std::move(words));
}

Json json_of(const Curve& curve)
{
    Json rows = Json::array();
    for (const CurveRow& row : curve.rows) {
        rows.push_back({{"budget_bytes_per_triangle", row.budget},
                        {"bytes_per_triangle", row.bytes},
                        {"seconds", row.seconds},
                        {"ns_a", row.ns[0]},
                        {"ns_b", row.ns[1]},
                        {"ns_c", row.ns[2]},
                        {"worst_case_blocks", row.worst_blocks}});
    }
    return rows;
}

} // namespace

Status run_budget_curve(const ProximityCommandOptions& options, Session& session)
{
    const auto mesh = session.load_model(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto index = build_mesh_index(*mesh, {.execution = session.execution()});
    if (!index) return at_model(index.error(), options.model);
    const auto curve = CurveRun(options, *mesh, *index, session).run();
    if (!curve) return at_model(curve.error(), options.model);

    session.print(fmt::format("Queries of {}, {} triangles, by the budget of its lists, "
                              "both in bytes per triangle\n\n{}",
                              options.model, mesh->triangle_count(), text_of(*curve)));
    for (const std::string& path : options.budget_curves) {
        Status status =
            write_plot([&] { return csv_of(*curve); },
                       [&] { return figure_of(*curve, options.model, mesh->triangle_count()); },
                       path, &session.progress());
        if (!status) return status;
        session.print(fmt::format("wrote {}\n", path));
    }
    Json enough; // null where larger budgets might still help
    if (curve->enough) enough = *curve->enough;
    return session.write_json({{"model", options.model},
                               {"triangles", mesh->triangle_count()},
                               {"method", "general"},
                               {"margin", options.margin},
                               {"queries_per_set", queries_per_set},
                               {"left_out", curve->left_out},
                               {"enough", enough},
                               {"rows", json_of(*curve)}});
}

} // namespace proxima
