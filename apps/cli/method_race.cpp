#include "cli/method_race.h"

#include "base/parallel.h"
#include "base/text.h"
#include "cli/stopwatch.h"
#include "cli/text_table.h"
#include "octree/same_cells.h"
#include "proxima/octree.h"

#include <algorithm>
#include <fmt/core.h>

namespace proxima {

namespace {

constexpr double long_run_seconds = 1.0; // one run is enough: noise is small beside it

struct Contender {
    OverlapMethod method{};
    std::vector<double> seconds;
    std::optional<Octree> octree;
};

double median(std::vector<double> values)
{
    std::ranges::sort(values);
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

/// Runs all methods at one depth, turn by turn.
Result<std::vector<Contender>> run_depth(const TriangleMesh& mesh, int depth,
                                         const MethodRaceOptions& options)
{
    std::vector<Contender> contenders;
    for (const OverlapMethod method : options.methods) contenders.push_back({method, {}, {}});
    for (int turn = 0; turn < options.repeats; ++turn) {
        for (Contender& contender : contenders) {
            if (turn > 0 && contender.seconds.front() > long_run_seconds) continue;
            const Stopwatch watch;
            auto octree =
                build_octree_by(mesh, {.method = contender.method, .exactness = options.exactness},
                                {.max_depth = depth,
                                 .threshold = options.threshold,
                                 .classification = Classification::none,
                                 .execution = options.execution});
            contender.seconds.push_back(watch.seconds());
            if (!octree) return tl::unexpected(octree.error());
            contender.octree = *octree;
        }
    }
    return contenders;
}

} // namespace

Result<std::vector<RaceRow>> race_methods(const TriangleMesh& mesh,
                                          const MethodRaceOptions& options)
{
    std::vector<RaceRow> rows;
    for (const int depth : options.depths) {
        const auto contenders = run_depth(mesh, depth, options);
        if (!contenders) return tl::unexpected(contenders.error());
        const auto separating_axis =
            std::ranges::find(*contenders, OverlapMethod::separating_axis, &Contender::method);
        for (const Contender& contender : *contenders) {
            const OctreeStatistics statistics = octree_statistics(*contender.octree);
            RaceRow row{.depth = depth,
                        .method = contender.method,
                        .total = statistics.total,
                        .references = statistics.references,
                        .seconds = median(contender.seconds),
                        .ratio_to_separating_axis = {},
                        .same_as_first =
                            same_cells(*contender.octree, *contenders->front().octree)};
            if (separating_axis != contenders->end()) {
                row.ratio_to_separating_axis = row.seconds / median(separating_axis->seconds);
            }
            rows.push_back(row);
        }
    }
    return rows;
}

std::string threads_text(Threads threads)
{
    const int count = thread_count(threads);
    return fmt::format("{} {}", count, count == 1 ? "thread" : "threads");
}

std::string race_text(const std::vector<RaceRow>& rows)
{
    TextTable table({"Depth", "Method", "Total", "Pointers", "Seconds", "x separating-axis"});
    for (const RaceRow& row : rows) {
        table.add_row({to_text(row.depth), std::string(method_name(row.method)), to_text(row.total),
                       to_text(row.references), fmt::format("{:.4f}", row.seconds),
                       row.ratio_to_separating_axis
                           ? fmt::format("{:.3g}", *row.ratio_to_separating_axis)
                           : "-"});
    }
    return table.text();
}

std::string agreement_text(const std::vector<RaceRow>& rows)
{
    const auto different = std::ranges::count(rows, false, &RaceRow::same_as_first);
    if (different == 0) return "All methods gave the same octree at each depth, list for list.";
    return fmt::format("{} of {} octrees differ from the first method's at their depth: rounding "
                       "decides otherwise where triangles only just touch or miss a cell.",
                       different, rows.size());
}

} // namespace proxima
