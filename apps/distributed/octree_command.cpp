#include "distributed/octree_command.h"

#include "cli/statistics_text.h"
#include "cli/text_table.h"
#include "distributed/classify_part.h"
#include "distributed/export_part.h"
#include "distributed/load_part.h"
#include "distributed/mesh_input.h"
#include "distributed/route_triangles.h"
#include "distributed/save_part.h"
#include "distributed/verify_octree.h"
#include "distributed/whole_caps.h"
#include "octree/classify_cells.h"
#include "octree/list_figures.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/core.h>
#include <limits>
#include <memory>

namespace proxima {

namespace {

bool is_octree_file(const std::string& model) noexcept
{
    return model.ends_with(".pxo");
}

/// Figures of the whole octree, as octree_statistics has them of one. Collective.
OctreeStatistics whole_statistics(const LeafCounter& counter, const World& world)
{
    const OctreeStatistics& own = counter.statistics;
    OctreeStatistics whole;
    whole.leaves = world.sum(own.leaves);
    whole.total = cells_of_leaves(whole.leaves);
    whole.occupied_leaves = world.sum(own.occupied_leaves);
    whole.references = world.sum(own.references);
    whole.inner = world.sum(own.inner);
    whole.outer = world.sum(own.outer);
    whole.boundary = world.sum(own.boundary);
    constexpr std::uint64_t none = std::numeric_limits<std::uint64_t>::max();
    whole.min_triangles =
        static_cast<std::uint32_t>(world.min(own.occupied_leaves == 0 ? none : own.min_triangles));
    whole.max_triangles = static_cast<std::uint32_t>(world.max(std::uint64_t{own.max_triangles}));
    whole.depth_reached =
        static_cast<int>(world.max(static_cast<std::uint64_t>(own.depth_reached)));
    whole.bytes = sizeof(OctreeNode) * ((whole.leaves - 1) / 7 + whole.occupied_leaves) +
                  sizeof(TriangleId) * whole.references;
    WideUnsigned sum_of_squares = 0;
    for (const std::uint64_t part : world.gather(counter.sum_of_squares)) sum_of_squares += part;
    set_list_figures(sum_of_squares, whole);
    return whole;
}

/// What each rank has. Collective.
std::string ranks_text(const OctreePart& part, const LeafCounter& counter, const World& world)
{
    const auto triangles = world.gather(part.triangles.size());
    const auto cells = world.gather(part.cells.size());
    const auto leaves = world.gather(counter.statistics.leaves);
    const auto pairs = world.gather(part.split_pairs);
    const auto references = world.gather(part.octree.references().size());
    const auto sent = world.gather(world.sent_bytes());
    const auto messages = world.gather(world.sent_messages());
    const auto work = world.gather(static_cast<std::uint64_t>(1e6 * part.work_seconds));
    const auto peak = world.gather(peak_megabytes());
    TextTable table({"Rank", "Cells", "Triangles", "Leaves", "Pairs split", "Pointers", "Work us",
                     "Messages", "Bytes sent", "Peak MB"});
    for (std::size_t r = 0; r < triangles.size(); ++r) {
        table.add_row({to_text(r), to_text(cells[r]), to_text(triangles[r]), to_text(leaves[r]),
                       to_text(pairs[r]), to_text(references[r]), to_text(work[r]),
                       to_text(messages[r]), to_text(sent[r]), to_text(peak[r])});
    }
    return table.text();
}

/// Grows this rank's cells. Not collective.
Result<GrownPart> grow(const RoutedPart& part, const OctreeFrame& frame,
                       const GrowCellsOptions& options)
{
    std::vector<CellTriangles> cells;
    const std::span<const TriangleId> lists = part.lists;
    for (std::size_t i = 0; i < part.keys.size(); ++i) {
        cells.push_back(
            {part.keys[i], lists.subspan(part.first[i], part.first[i + 1] - part.first[i])});
    }
    return grow_part(part.mesh, frame, cells, CellsElsewhere::recorded, options);
}

/// This rank's part of the octree of a slice of the mesh. Collective.
Result<OctreePart> build_part(MeshSlice slice, const OctreeFrame& frame,
                              const OctreeRunOptions& options, World& world)
{
    const auto caps = whole_caps(slice, world);
    if (!caps) return tl::unexpected(caps.error());
    auto routed = route_triangles(std::move(slice), frame,
                                  {.max_depth = options.depth,
                                   .threshold = options.threshold,
                                   .routing_depth = options.routing_depth},
                                  world);
    if (!routed) return tl::unexpected(routed.error());
    const GrowCellsOptions grow_options{.max_depth = options.depth,
                                        .threshold = options.threshold,
                                        .execution = {.progress = &world.progress()}};
    GrownPart grown;
    const Status status = world.agree_on([&]() -> Status {
        auto result = grow(*routed, frame, grow_options);
        if (!result) return tl::unexpected(result.error());
        grown = std::move(*result);
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    const OctreeParameters parameters = part_parameters(grow_options);
    const auto summary = classify_part(*routed, frame, parameters, *caps, grown, world);
    if (!summary) return tl::unexpected(summary.error());
    OctreePart part;
    part.cells = std::move(grown.cells);
    part.upper_records = grown.upper_records;
    part.split_pairs = grown.split_pairs;
    const auto arrays = std::make_shared<OctreeOutput>(std::move(grown.arrays));
    part.octree =
        Octree::adopt(frame, classified(parameters, *summary), routed->mesh.triangle_count(),
                      arrays->nodes.span(), arrays->references.span(), arrays);
    part.triangles = std::move(routed->triangles);
    return part;
}

/// The octree of a model, and on rank 0 a line about it. Collective.
Result<OctreePart> octree_of(const OctreeRunOptions& options, World& world, std::string& line)
{
    const double start = MPI_Wtime();
    if (is_octree_file(options.model)) {
        auto part = load_part(options.model, options.routing_depth, world);
        if (!part) return part;
        part->work_seconds = world.work_seconds();
        line = fmt::format("{}: {} triangles, {} ranks, loaded in {:.3f} s", options.model,
                           part->whole_triangles, world.size(), MPI_Wtime() - start);
        return part;
    }
    auto slice = load_slice(options.model, options.triangles, world);
    if (!slice) return tl::unexpected(slice.error());
    const auto box = whole_box(*slice, world);
    if (!box) return tl::unexpected(box.error());
    const std::uint64_t whole_triangles = slice->whole_triangles;
    const double loaded = MPI_Wtime();
    const double work_before = world.work_seconds();
    auto part = build_part(std::move(*slice), tight_root(*box, RootShape::cube), options, world);
    if (!part) return part;
    part->whole_triangles = whole_triangles;
    part->work_seconds = world.work_seconds() - work_before;
    MPI_Barrier(MPI_COMM_WORLD);
    line =
        fmt::format("{}: {} triangles, {} ranks, read in {:.3f} s, built in {:.3f} s, the busiest "
                    "rank's work {:.3f} s",
                    options.model, whole_triangles, world.size(), loaded - start,
                    MPI_Wtime() - loaded, world.max(part->work_seconds));
    return part;
}

/// Builds or loads the octree, prints its figures on rank 0 and writes what is asked for. Collective.
Status run_octree(const OctreeRunOptions& options, World& world)
{
    std::string line;
    const auto part = octree_of(options, world, line);
    if (!part) return tl::unexpected(part.error());
    if (!options.save.empty()) {
        Status saved = save_part(*part, options.save, world);
        if (!saved) return saved;
    }
    if (!options.out.empty()) {
        Status exported = export_part(*part, options.out, world);
        if (!exported) return exported;
    }
    LeafCounter counter;
    for (const Cell& cell : part->cells) traverse_below(part->octree, cell, counter);
    const OctreeStatistics statistics = whole_statistics(counter, world);
    const std::string ranks = ranks_text(*part, counter, world);
    if (world.rank() == 0) {
        fmt::print("{}\n\n{}\n{}", line, statistics_text(part->octree.parameters(), statistics),
                   ranks);
        std::fflush(stdout);
    }
    if (!options.is_verified) return {};
    Status verified = verify_octree(options, *part, world);
    if (!verified) return verified;
    if (world.rank() == 0) {
        fmt::print("\nLeaves, lists and classes are those of one process.\n");
    }
    return {};
}

CLI::Validator ends_with(const std::string& extension)
{
    return {[extension](const std::string& name) {
                return name.ends_with(extension) ? std::string()
                                                 : "the name must end with " + extension;
            },
            "FILE" + extension};
}

} // namespace

std::function<Status(World&)> add_octree_command(CLI::App& app)
{
    const auto options = std::make_shared<OctreeRunOptions>();
    CLI::App* const command =
        app.add_subcommand("octree", "Build the octree of a mesh, each process a part of it");
    command
        ->add_option(
            "MODEL", options->model,
            "A binary little-endian .ply file, torus:NxM, an octree's .pxo file, or vertices "
            "as a .npy file")
        ->required();
    command->add_option("--triangles", options->triangles,
                        "A .npy file: three numbers of vertices, from 0, for each triangle");
    command->add_option("--depth", options->depth, "Deepest level, 0 to 18 (default 5)")
        ->check(CLI::Range(0, max_octree_depth - 1));
    command
        ->add_option("--threshold", options->threshold,
                     "Split cells with more triangles than this (default 1)")
        ->check(CLI::Range(0U, 1U << 30U));
    command
        ->add_option("--routing-depth", options->routing_depth,
                     "Deepest level whose cells are shared out, 0 to 7 (default 5)")
        ->check(CLI::Range(0, max_routing_depth));
    command->add_flag("--verify", options->is_verified,
                      "Build the whole octree on the first process, too, and compare");
    command->add_option("--save", options->save, "Write the octree's own format, as proxima does")
        ->check(ends_with(".pxo"));
    command->add_option("--out", options->out, "Write the leaves for ParaView, a piece per process")
        ->check(ends_with(".pvtu"));
    return [options, command](World& world) -> Status {
        for (const char* const name : {"--depth", "--threshold", "--triangles", "--verify"}) {
            if (is_octree_file(options->model) && command->count(name) != 0) {
                return fail(ErrorCode::invalid_argument,
                            concat(name, " is for meshes: an octree's file has been built"),
                            options->model);
            }
        }
        if (options->is_verified && !options->triangles.empty()) {
            return fail(ErrorCode::invalid_argument,
                        "--verify is for meshes that one process reads: write a .ply file",
                        options->triangles);
        }
        return run_octree(*options, world);
    };
}

} // namespace proxima
