#include "proxima/octree.h"

#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"
#include "octree/build_fast.h"
#include "octree/build_octree_with.h"
#include "octree/classify_cells.h"
#include "octree/reaching_edge.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <new>
#include <utility>

namespace proxima {

namespace {

Status check_options(const Box& box, const OctreeOptions& options)
{
    if (options.max_depth < 0 || options.max_depth > max_octree_depth) {
        return fail(ErrorCode::invalid_argument,
                    concat("the maximum depth must be 0 to ", max_octree_depth, ", not ",
                           options.max_depth));
    }
    constexpr double largest = 1e100;
    if (box.lower.minCoeff() < -largest || box.upper.maxCoeff() > largest) {
        return fail(ErrorCode::invalid_mesh,
                    "coordinates beyond 1e100 would overflow exact arithmetic: scale the mesh");
    }
    if (!options.root) return {};
    const OctreeFrame& root = *options.root;
    if (!root.lower.allFinite() || !root.edge.allFinite() || root.edge.minCoeff() <= 0) {
        return fail(ErrorCode::invalid_argument,
                    "the given root must have finite corners and positive edges");
    }
    if (!cell_box(root, CellKey{}).contains(box.lower) ||
        !cell_box(root, CellKey{}).contains(box.upper)) {
        return fail(ErrorCode::invalid_argument,
                    "the given root does not contain the mesh: enlarge it");
    }
    return {};
}

/// Records for all cells down to the maximum depth, empty ones included.
Status fill_uniformly(int max_depth, const GrowLimits& limits, OctreeOutput& output)
{
    const std::uint64_t total = ((std::uint64_t{1} << (3 * (max_depth + 1))) - 1) / 7;
    if (total > std::numeric_limits<std::uint32_t>::max() / 2) {
        return fail(ErrorCode::limit_exceeded,
                    concat("a uniform octree of depth ", max_depth, " has ", total,
                           " cells: at most 2^31 are possible, lower the depth"));
    }
    StageSteps steps(limits.progress, "uniform cells", total);
    GrowBuffer<OctreeNode> nodes;
    nodes.reserve(total);
    nodes.push_back(output.nodes[0]);
    // Breadth first: sources[i] is the adaptive record of node first + i, or none where empty.
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> sources = {0};
    std::size_t first = 0;
    for (int depth = 0; depth < max_depth; ++depth) {
        std::vector<std::uint32_t> children;
        children.reserve(8 * sources.size());
        for (std::size_t i = 0; i < sources.size(); ++i) {
            if (!steps.done(8)) return cancelled("building the octree");
            const bool is_empty = sources[i] == none;
            const OctreeNode source = is_empty ? OctreeNode{} : output.nodes[sources[i]];
            OctreeNode node = OctreeNode::split(static_cast<std::uint32_t>(nodes.size()), 0xFF);
            if (is_empty) node.packed |= OctreeNode::empty_split_bit;
            nodes[first + i] = node;
            std::uint32_t next = source.first;
            for (unsigned octant = 0; octant < 8; ++octant) {
                const bool recorded = !is_empty && (source.recorded_mask() >> octant & 1U) != 0;
                children.push_back(recorded ? next : none);
                nodes.push_back(recorded ? output.nodes[next] : OctreeNode::leaf(0, 0));
                if (recorded) ++next;
            }
        }
        first += sources.size();
        sources = std::move(children);
    }
    output.nodes = std::move(nodes);
    return {};
}

Result<OctreeOutput> build_arrays(const TriangleMesh& mesh, const OctreeFrame& frame,
                                  const OctreeOptions& options, const ListFinder& finder)
{
    const bool uniform = options.subdivision == Subdivision::uniform;
    GrowLimits limits;
    limits.max_depth = options.max_depth;
    limits.threshold = uniform ? 0 : options.threshold;
    limits.budget_bytes = budget_bytes(options.execution.budget);
    limits.progress = options.execution.progress;
    if (uniform) {
        const std::uint64_t cells = ((std::uint64_t{1} << (3 * (options.max_depth + 1))) - 1) / 7;
        const auto status = check_budget(
            options.execution.budget, cells * (sizeof(OctreeNode) + 2 * sizeof(std::uint32_t)),
            "the uniform octree", "lower the depth, subdivide adaptively or raise the budget");
        if (!status) return tl::unexpected(status.error());
    }
    OctreeOptions used = options;
    used.threshold = limits.threshold;
    auto output = finder.find(mesh, frame, used, limits);
    if (!output) return output;
    if (uniform) {
        if (auto status = fill_uniformly(options.max_depth, limits, *output); !status) {
            return tl::unexpected(status.error());
        }
    }
    return output;
}

Result<Octree> build_unguarded(const TriangleMesh& mesh, const OctreeOptions& options,
                               const ListFinder& finder)
{
    const auto box = checked_bounding_box(mesh);
    if (!box) return tl::unexpected(box.error());
    if (auto status = check_options(*box, options); !status) return tl::unexpected(status.error());
    const OctreeFrame frame = options.root ? *options.root : tight_root(*box, options.root_shape);
    auto arrays = build_arrays(mesh, frame, options, finder);
    if (!arrays) return tl::unexpected(arrays.error());
    const auto storage = std::make_shared<OctreeOutput>(std::move(*arrays));
    const auto adopt = [&](const OctreeParameters& parameters) {
        return Octree::adopt(frame, parameters, mesh.triangle_count(), storage->nodes.span(),
                             storage->references.span(), storage);
    };
    const OctreeParameters parameters{.max_depth = options.max_depth,
                                      .threshold = options.threshold,
                                      .method = finder.method,
                                      .subdivision = options.subdivision,
                                      .exact = finder.is_exact};
    const Octree octree = adopt(parameters);
    if (options.classification == Classification::none) return octree;
    const auto summary = classify_nodes(octree, storage->nodes.span(), mesh, options.execution);
    if (!summary) return tl::unexpected(summary.error());
    return adopt(classified(parameters, *summary));
}

} // namespace

OctreeFrame tight_root(const Box& box, RootShape shape) noexcept
{
    const double magnitude =
        std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
    const double smallest = 1e-6 * std::max(magnitude, 1.0);
    const Vec3 center = box.center();
    Vec3 edge = box.extent();
    if (shape == RootShape::cube) edge = Vec3::Constant(edge.maxCoeff());
    OctreeFrame frame;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(edge[axis] > 0)) edge[axis] = smallest;
        frame.lower[axis] = std::min(center[axis] - edge[axis] / 2, box.lower[axis]);
        frame.edge[axis] = reaching_edge(frame.lower[axis], edge[axis], box.upper[axis]);
    }
    if (shape == RootShape::cube) frame.edge = Vec3::Constant(frame.edge.maxCoeff());
    return frame;
}

Result<Octree> build_octree_with(const TriangleMesh& mesh, const OctreeOptions& options,
                                 const ListFinder& finder)
{
    try {
        return build_unguarded(mesh, options, finder);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::budget_exceeded,
                    "memory ran out: lower the depth, raise the threshold or set a budget");
    }
}

Result<Octree> build_octree(const TriangleMesh& mesh, const OctreeOptions& options)
{
    return build_octree_with(mesh, options,
                             {.method = OverlapMethod::fast, .is_exact = true, .find = build_fast});
}

} // namespace proxima
