#include "distributed/query_report.h"

#include "cli/text_table.h"

#include <cstdio>
#include <fmt/core.h>

namespace proxima {

void report_queries(const QueryOptions& options, const MeshPart& part, std::uint64_t queries,
                    std::string_view what, const QueryTimes& times, const World& world)
{
    const auto triangles = world.gather(part.triangles.size());
    const auto bytes = world.gather(part.index.bytes());
    const auto build_bytes = world.gather(times.build_bytes);
    const auto answer_bytes = world.gather(world.sent_bytes() - times.build_bytes);
    const auto peak = world.gather(peak_megabytes());
    if (world.rank() != 0 || options.out == "-") return;
    TextTable table(
        {"Rank", "Triangles", "Index bytes", "Bytes sent to build", "to answer", "Peak MB"});
    for (std::size_t r = 0; r < triangles.size(); ++r) {
        table.add_row({to_text(r), to_text(triangles[r]), to_text(bytes[r]),
                       to_text(build_bytes[r]), to_text(answer_bytes[r]), to_text(peak[r])});
    }
    fmt::print("{}: {} triangles, {} ranks, read and indexed in {:.3f} s\n"
               "{} {} answered in {:.3f} s, {:.0f} ns each\nwrote {}\n\n{}",
               options.model, part.whole_triangles, world.size(), times.build_seconds, queries,
               what, times.answer_seconds,
               1e9 * times.answer_seconds / static_cast<double>(queries), options.out,
               table.text());
    if (options.is_verified) fmt::print("\nAnswers are those of one process.\n");
    std::fflush(stdout);
}

} // namespace proxima
