#include "cli/statistics_text.h"

#include "base/text.h"
#include "cli/text_table.h"

#include <fmt/core.h>

namespace proxima {

std::string statistics_text(const OctreeParameters& parameters, const OctreeStatistics& statistics)
{
    TextTable counts({"Depth", "Threshold", "Total", "Leaves", "Occ. %", "Min-Tri", "Max-Tri",
                      "Pointers", "Mean", "Std.", "Mean/all", "Std./all"});
    counts.add_row(
        {to_text(parameters.max_depth), to_text(parameters.threshold), to_text(statistics.total),
         to_text(statistics.leaves), fmt::format("{:.1f}", statistics.occupied_percent),
         to_text(statistics.min_triangles), to_text(statistics.max_triangles),
         to_text(statistics.references), fmt::format("{:.2f}", statistics.mean_triangles),
         fmt::format("{:.2f}", statistics.std_triangles),
         fmt::format("{:.2f}", statistics.mean_all_leaves),
         fmt::format("{:.2f}", statistics.std_all_leaves)});
    TextTable classes({"Boundary", "Inner", "Outer", "Depth reached", "Bytes", "Bytes/pointer"});
    classes.add_row({to_text(statistics.boundary), to_text(statistics.inner),
                     to_text(statistics.outer), to_text(statistics.depth_reached),
                     to_text(statistics.bytes),
                     statistics.references == 0
                         ? "-"
                         : fmt::format("{:.1f}", static_cast<double>(statistics.bytes) /
                                                     static_cast<double>(statistics.references))});
    std::string text = counts.text() + '\n' + classes.text();
    const ClassificationSummary& summary = parameters.classification;
    if (summary.leaked_components > 0) {
        text += fmt::format("\nThe mesh has holes: {} of {} regions of empty leaves reach both "
                            "sides, their {} leaves were classified one by one.\n",
                            summary.leaked_components, summary.components, summary.leaked_leaves);
    }
    return text;
}

} // namespace proxima
