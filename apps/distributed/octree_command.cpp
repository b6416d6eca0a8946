#include "distributed/octree_command.h"

#include "cli/text_table.h"
#include "distributed/mesh_input.h"
#include "distributed/route_triangles.h"
#include "distributed/verify_octree.h"
#include "octree/list_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/core.h>
#include <limits>

namespace proxima {

namespace {

struct LeafCounter {
    OctreeStatistics statistics;
    std::uint64_t sum_of_squares = 0; // below 2^64: a rank's lists sum to at most 2^31

    static bool should_enter(const Cell&) noexcept { return true; }
    Flow visit_leaf(const Cell& cell, std::span<const TriangleId> triangles) noexcept
    {
        ++statistics.leaves;
        statistics.depth_reached = std::max(statistics.depth_reached, depth(cell.key));
        if (triangles.empty()) return Flow::proceed;
        const auto count = static_cast<std::uint32_t>(triangles.size());
        statistics.min_triangles =
            statistics.occupied_leaves == 0 ? count : std::min(statistics.min_triangles, count);
        statistics.max_triangles = std::max(statistics.max_triangles, count);
        ++statistics.occupied_leaves;
        statistics.references += count;
        sum_of_squares += std::uint64_t{count} * count;
        return Flow::proceed;
    }
};

/// Figures of the whole octree, as octree_statistics has them of one. Collective.
OctreeStatistics whole_statistics(const GrownCells& grown, const World& world)
{
    LeafCounter counter;
    for (const Cell& cell : grown.cells) traverse_below(grown.octree, cell, counter);
    const OctreeStatistics& own = counter.statistics;
    OctreeStatistics whole;
    whole.leaves = world.sum(own.leaves);
    whole.total = whole.leaves + (whole.leaves - 1) / 7; // every split cell has eight children
    whole.occupied_leaves = world.sum(own.occupied_leaves);
    whole.references = world.sum(own.references);
    whole.boundary = whole.occupied_leaves;
    constexpr std::uint64_t none = std::numeric_limits<std::uint64_t>::max();
    whole.min_triangles =
        static_cast<std::uint32_t>(world.min(own.occupied_leaves == 0 ? none : own.min_triangles));
    whole.max_triangles = static_cast<std::uint32_t>(world.max(own.max_triangles));
    whole.depth_reached =
        static_cast<int>(world.max(static_cast<std::uint64_t>(own.depth_reached)));
    whole.bytes = sizeof(OctreeNode) * ((whole.leaves - 1) / 7 + whole.occupied_leaves) +
                  sizeof(TriangleId) * whole.references;
    WideUnsigned sum_of_squares = 0;
    for (const std::uint64_t part : world.gather(counter.sum_of_squares)) sum_of_squares += part;
    set_list_figures(sum_of_squares, whole);
    return whole;
}

std::string figures_text(const OctreeRunOptions& options, const OctreeStatistics& statistics)
{
    TextTable counts({"Depth", "Threshold", "Total", "Leaves", "Occ. %", "Min-Tri", "Max-Tri",
                      "Pointers", "Mean", "Std.", "Mean/all", "Std./all"});
    counts.add_row({to_text(options.depth), to_text(options.threshold), to_text(statistics.total),
                    to_text(statistics.leaves), fmt::format("{:.1f}", statistics.occupied_percent),
                    to_text(statistics.min_triangles), to_text(statistics.max_triangles),
                    to_text(statistics.references),
                    fmt::format("{:.2f}", statistics.mean_triangles),
                    fmt::format("{:.2f}", statistics.std_triangles),
                    fmt::format("{:.2f}", statistics.mean_all_leaves),
                    fmt::format("{:.2f}", statistics.std_all_leaves)});
    TextTable size({"Boundary", "Empty", "Depth reached", "Bytes", "Bytes/pointer"});
    size.add_row({to_text(statistics.boundary), to_text(statistics.leaves - statistics.boundary),
                  to_text(statistics.depth_reached), to_text(statistics.bytes),
                  fmt::format("{:.1f}", static_cast<double>(statistics.bytes) /
                                            static_cast<double>(statistics.references))});
    return counts.text() + '\n' + size.text();
}

/// What each rank has. Collective.
std::string ranks_text(const RoutedPart& part, const GrownCells& grown, const World& world)
{
    const auto triangles = world.gather(part.triangles.size());
    const auto cells = world.gather(part.keys.size());
    const auto references = world.gather(grown.octree.references().size());
    const auto sent = world.gather(world.sent_bytes());
    const auto peak = world.gather(peak_megabytes());
    TextTable table({"Rank", "Cells", "Triangles", "Pointers", "Bytes sent", "Peak MB"});
    for (std::size_t r = 0; r < triangles.size(); ++r) {
        table.add_row({to_text(r), to_text(cells[r]), to_text(triangles[r]), to_text(references[r]),
                       to_text(sent[r]), to_text(peak[r])});
    }
    return table.text();
}

} // namespace

Status run_octree(const OctreeRunOptions& options, World& world)
{
    const double start = MPI_Wtime();
    auto slice = load_slice(options.model, world);
    if (!slice) return tl::unexpected(slice.error());
    const auto box = whole_box(*slice, world);
    if (!box) return tl::unexpected(box.error());
    const OctreeFrame frame = tight_root(*box, RootShape::cube);
    const std::uint64_t whole_triangles = slice->whole_triangles;
    const double loaded = MPI_Wtime();
    const auto part = route_triangles(std::move(*slice), frame,
                                      {.max_depth = options.depth,
                                       .threshold = options.threshold,
                                       .routing_depth = options.routing_depth},
                                      world);
    if (!part) return tl::unexpected(part.error());
    GrownCells grown;
    const Status status = world.agree_on([&]() -> Status {
        std::vector<CellTriangles> cells;
        const std::span<const TriangleId> lists = part->lists;
        for (std::size_t i = 0; i < part->keys.size(); ++i) {
            cells.push_back({part->keys[i],
                             lists.subspan(part->first[i], part->first[i + 1] - part->first[i])});
        }
        auto result = grow_cells(part->mesh, frame, cells,
                                 {.max_depth = options.depth, .threshold = options.threshold});
        if (!result) return tl::unexpected(result.error());
        grown = std::move(*result);
        return {};
    });
    if (!status) return status;
    MPI_Barrier(MPI_COMM_WORLD);
    const double built = MPI_Wtime();
    const OctreeStatistics statistics = whole_statistics(grown, world);
    const std::string ranks = ranks_text(*part, grown, world);
    if (world.rank() == 0) {
        fmt::print("{}: {} triangles, {} ranks, read in {:.3f} s, built in {:.3f} s\n\n{}\n"
                   "Empty leaves are not classified as inner and outer.\n\n{}",
                   options.model, whole_triangles, world.size(), loaded - start, built - loaded,
                   figures_text(options, statistics), ranks);
        std::fflush(stdout);
    }
    if (!options.is_verified) return {};
    const Status verified = verify_octree(options, *part, grown, world);
    if (!verified) return verified;
    if (world.rank() == 0) fmt::print("\nLeaves and lists are those of one process.\n");
    return {};
}

} // namespace proxima
