#include "octree/build_fast.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "octree/coarse_bins.h"
#include "octree/fast_child_test.h"
#include "octree/top_tree.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace proxima {

namespace {

/// Grows subtrees [begin, end) into `output`; their own nodes go to `roots`.
Status grow_range(const SnappedMesh& mesh, const CoarseBins& bins,
                  const std::vector<SubtreeSlot>& slots, std::size_t begin, std::size_t end,
                  GrowLimits& limits, OctreeOutput& output, std::vector<OctreeNode>& roots)
{
    SubtreeGrower grower(limits);
    FastChildTest test(mesh);
    for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t cell = slots[i].cell;
        const auto root = grower.grow({grid_corner({std::uint64_t{1} << (3 * bins.depth) | cell}),
                                       bins.depth, bins.triangles(cell)},
                                      test, output);
        if (!root) return tl::unexpected(root.error());
        roots[i] = *root;
        advance_stage(limits.progress, bins.count(cell));
    }
    return {};
}

/// The bounds of `chunks` runs of subtrees with about equal numbers of triangles.
std::vector<std::size_t> balance(const CoarseBins& bins, const std::vector<SubtreeSlot>& slots,
                                 std::size_t chunks)
{
    std::uint64_t total = 0;
    for (const SubtreeSlot& slot : slots) total += bins.count(slot.cell);
    std::vector<std::size_t> bounds = {0};
    std::uint64_t done = 0;
    for (std::size_t i = 0; i < slots.size(); ++i) {
        done += bins.count(slots[i].cell);
        if (done * chunks >= total * bounds.size()) bounds.push_back(i + 1);
    }
    if (bounds.back() != slots.size()) bounds.push_back(slots.size());
    return bounds;
}

/// A node whose offsets counted from a chunk's start, moved to the whole.
OctreeNode moved(OctreeNode node, std::uint32_t nodes, std::uint32_t references) noexcept
{
    node.first += node.is_leaf() ? references : nodes;
    return node;
}

/// Appends the chunks to the top in order, in parallel, freeing each.
Status join(std::vector<OctreeOutput>& chunks, const std::vector<std::size_t>& bounds,
            const std::vector<SubtreeSlot>& slots, const std::vector<OctreeNode>& roots,
            Threads threads, Progress* progress, OctreeOutput& output)
{
    std::vector<std::size_t> first_node;
    std::vector<std::size_t> first_reference;
    std::size_t nodes = output.nodes.size();
    std::size_t references = output.references.size();
    for (const OctreeOutput& chunk : chunks) {
        first_node.push_back(nodes);
        first_reference.push_back(references);
        nodes += chunk.nodes.size();
        references += chunk.references.size();
    }
    if (std::max(nodes, references) > std::numeric_limits<std::uint32_t>::max() / 2) {
        return fail(ErrorCode::limit_exceeded,
                    "the octree needs more than 2^31 cells or triangle references: lower the depth "
                    "or raise the threshold");
    }
    output.nodes.resize(nodes);
    output.references.resize(references);
    parallel_for(chunks.size(), threads, [&](std::size_t index) {
        if (is_cancelled(progress)) return;
        OctreeOutput& chunk = chunks[index];
        const auto node_offset = static_cast<std::uint32_t>(first_node[index]);
        const auto reference_offset = static_cast<std::uint32_t>(first_reference[index]);
        for (std::size_t i = 0; i < chunk.nodes.size(); ++i) {
            output.nodes[node_offset + i] = moved(chunk.nodes[i], node_offset, reference_offset);
        }
        std::copy(chunk.references.begin(), chunk.references.end(),
                  output.references.begin() + reference_offset);
        for (std::size_t i = bounds[index]; i < bounds[index + 1]; ++i) {
            output.nodes[slots[i].record] = moved(roots[i], node_offset, reference_offset);
        }
        chunk = OctreeOutput{};
    });
    if (is_cancelled(progress)) return cancelled("building the octree");
    return {};
}

} // namespace

Result<OctreeOutput> build_fast(const TriangleMesh& mesh, const OctreeFrame& frame,
                                const OctreeOptions& options, GrowLimits& limits)
{
    // Vertices on the grid, and a coverage and an id per triangle: before anything is allocated.
    limits.used_bytes += sizeof(SnappedPoint) * mesh.vertex_count() +
                         2 * sizeof(std::uint32_t) * mesh.triangle_count();
    const auto fits = check_budget({limits.budget_bytes}, limits.used_bytes, "the octree's scratch",
                                   "raise the budget");
    if (!fits) return tl::unexpected(fits.error());
    begin_stage(options.execution.progress, "snapping",
                mesh.vertex_count() + 2 * mesh.triangle_count());
    const SnappedMesh snapped(mesh, frame, options.execution.threads, options.execution.progress);
    if (is_cancelled(options.execution.progress)) return cancelled("building the octree");
    const int bin_depth = choose_bin_depth(snapped, options.max_depth);
    const auto binned =
        bin_triangles_within(limits.budget_bytes - limits.used_bytes, snapped, bin_depth,
                             options.execution.threads, options.execution.progress);
    if (!binned) return tl::unexpected(binned.error());
    const CoarseBins& bins = *binned;
    if (is_cancelled(options.execution.progress)) return cancelled("building the octree");
    limits.used_bytes += sizeof(std::uint32_t) * (bins.ids.size() - mesh.triangle_count());

    OctreeOutput output;
    const std::vector<SubtreeSlot> slots = build_top_tree(bins, options.threshold, output);
    begin_stage(options.execution.progress, "octree", bins.ids.size());
    std::vector<OctreeNode> roots(slots.size());
    if (thread_count(options.execution.threads) == 1) {
        // One thread writes in place; offsets are final.
        const Status status =
            grow_range(snapped, bins, slots, 0, slots.size(), limits, output, roots);
        if (!status) return tl::unexpected(status.error());
        for (std::size_t i = 0; i < slots.size(); ++i) output.nodes[slots[i].record] = roots[i];
    } else {
        constexpr std::size_t chunk_count = 64;
        const auto bounds = balance(bins, slots, chunk_count);
        std::vector<OctreeOutput> chunks(bounds.size() - 1);
        std::vector<Status> statuses(chunks.size());
        parallel_for(chunks.size(), options.execution.threads, [&](std::size_t index) {
            statuses[index] = grow_range(snapped, bins, slots, bounds[index], bounds[index + 1],
                                         limits, chunks[index], roots);
        });
        for (const Status& status : statuses) {
            if (!status) return tl::unexpected(status.error());
        }
        // The chunks are copied and freed one by one; the whole is there beside them.
        std::uint64_t joined = 0;
        for (const OctreeOutput& chunk : chunks) joined += bytes(chunk);
        auto status = check_budget({limits.budget_bytes}, limits.used_bytes + joined, "the octree",
                                   "use one thread, lower the depth or raise the budget");
        if (status) {
            status = join(chunks, bounds, slots, roots, options.execution.threads,
                          options.execution.progress, output);
        }
        if (!status) return tl::unexpected(status.error());
    }
    output.nodes.shrink_to_fit();
    output.references.shrink_to_fit();
    return output;
}

} // namespace proxima
