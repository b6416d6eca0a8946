// Pairs of instances: each leaf of the tree looks for leaves that meet its box, and each pair of instances is found
// by the one whose row comes first.
#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/index_parts.h"
#include "proxima/intersect_meshes.h"
#include "proxima/scene.h"
#include "query/scene/found_lists.h"
#include "query/scene/scene_parts.h"
#include "query/scene/walk_scene.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

namespace {

constexpr std::size_t leaves_per_task = 16;

/// How near boxes must be.
class BoxReach {
public:
    explicit BoxReach(double distance) noexcept : distance_(distance) {}

    /// Holds all that is near the box.
    [[nodiscard]] Box around(const Box& box) const noexcept
    {
        return {box.lower.array() - distance_, box.upper.array() + distance_};
    }
    [[nodiscard]] bool has(const Box& a, const Box& b) const noexcept
    {
        const bool apart =
            (a.lower.array() > b.upper.array()).any() || (b.lower.array() > a.upper.array()).any();
        return !apart || (distance_ > 0 && is_near(a, b));
    }

private:
    [[nodiscard]] bool is_near(const Box& a, const Box& b) const noexcept
    {
        double squared = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double gap =
                std::max({a.lower[axis] - b.upper[axis], b.lower[axis] - a.upper[axis], 0.0});
            if (gap > distance_) return false;
            // In units of the distance: squares of very small numbers are zero.
            squared += gap / distance_ * (gap / distance_);
        }
        return squared <= 1 + 0x1p-50;
    }

    double distance_;
};

bool are_wanted(const SceneRow& a, const SceneRow& b, const ScenePairOptions& options) noexcept
{
    return ((a.layers & options.layers) != 0 && (b.layers & options.others) != 0) ||
           ((b.layers & options.layers) != 0 && (a.layers & options.others) != 0);
}

/// Rows of a pair, that of the lower instance first.
struct PairRows {
    std::uint32_t a;
    std::uint32_t b;
};

/// The leaves of the tree, depth first. They are some of its blocks.
std::vector<const IndexLeaf*> leaves_of(const IndexParts& tree)
{
    std::vector<const IndexLeaf*> leaves;
    if (tree.triangle_count() == 0) return leaves;
    leaves.reserve(tree.blocks().size());
    std::vector<std::uint32_t> pending = {tree.root()};
    while (!pending.empty()) {
        const std::uint32_t at = pending.back();
        pending.pop_back();
        const IndexBlock& block = tree.blocks()[at & ~index_leaf_bit];
        if ((at & index_leaf_bit) != 0) {
            leaves.push_back(&block.leaf);
            continue;
        }
        for (std::size_t slot = 0; slot < 8; ++slot)
            if (block.node.has_child(slot)) pending.push_back(block.node.children[slot]);
    }
    return leaves;
}

/// Calls visit(row, other) for all pairs whose boxes are near enough, row in the leaf and other behind it.
template <class Visit>
void visit_pairs_of(const SceneParts& scene, const IndexLeaf& leaf, const BoxReach& reach,
                    const Visit& visit)
{
    const std::uint32_t end = leaf.first_row + leaf.count;
    Box box;
    for (const SceneRow& row : std::span(scene.rows).subspan(leaf.first_row, leaf.count)) {
        box.extend(row.box.lower);
        box.extend(row.box.upper);
    }
    const IndexParts& tree = scene.tree.parts();
    visit_scene_leaves(tree, FloatQueryBox(tree, reach.around(box)), [&](const IndexLeaf& near) {
        const std::uint32_t near_end = near.first_row + near.count;
        for (std::uint32_t row = leaf.first_row; row < end; ++row) {
            for (std::uint32_t other = std::max(near.first_row, row + 1); other < near_end; ++other)
                if (reach.has(scene.rows[row].box, scene.rows[other].box)) visit(row, other);
        }
    });
}

/// All pairs for which ask(rows) has an answer, ascending. Errors: budget_exceeded, cancelled.
template <class Found, class Ask>
Result<std::vector<Found>> find_pairs(const SceneParts& scene, const BoxReach& reach,
                                      const ScenePairOptions& options, const Ask& ask)
{
    const Execution& execution = options.execution;
    begin_stage(execution.progress, "finding pairs", scene.tree_rows());
    const std::uint64_t listed = scene.tree.parts().blocks().size();
    // NOLINTNEXTLINE(bugprone-sizeof-expression): pointers are listed
    const std::uint64_t taken = listed * sizeof(const IndexLeaf*);
    const std::uint64_t tasks = chunk_count(listed, leaves_per_task);
    if (Status status =
            check_budget(execution.budget, taken + FoundLists<Found>::bytes_of_tasks(tasks),
                         "the search for pairs", "take fewer instances or raise the budget");
        !status)
        return tl::unexpected(status.error());
    const std::vector<const IndexLeaf*> leaves = leaves_of(scene.tree.parts());
    FoundLists<Found> found(tasks, execution.budget, taken);
    const auto is_over = [&] { return is_cancelled(execution.progress) || found.is_over(); };
    const auto work = [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end && !is_over(); ++i) {
            visit_pairs_of(scene, *leaves[i], reach, [&](std::uint32_t row, std::uint32_t other) {
                const SceneRow& a = scene.rows[row];
                const SceneRow& b = scene.rows[other];
                if (!are_wanted(a, b, options) || is_over()) return;
                const auto answer =
                    ask(a.instance < b.instance ? PairRows{row, other} : PairRows{other, row});
                if (answer) found.add(first / leaves_per_task, *answer);
            });
            advance_stage(execution.progress, leaves[i]->count);
        }
    };
    parallel_chunks(leaves.size(), leaves_per_task, execution.threads, work);
    if (is_cancelled(execution.progress)) return cancelled("finding pairs");
    if (found.is_over()) {
        return fail(ErrorCode::budget_exceeded,
                    concat("there are more than ", found.most(),
                           " pairs, which the memory budget does not hold; take fewer instances, a "
                           "smaller distance or layers, or raise the budget"));
    }
    std::vector<Found> all = found.take();
    std::ranges::sort(
        all, [](const Found& x, const Found& y) { return x.a < y.a || (x.a == y.a && x.b < y.b); });
    return all;
}

Status check_distance(double distance)
{
    if (distance >= 0 && std::isfinite(distance)) return {};
    return fail(ErrorCode::invalid_argument,
                concat("a distance of ", distance, "; give a finite one from 0 up"));
}

InstancePair pair_of(const SceneParts& scene, const PairRows& rows) noexcept
{
    return {InstanceId{scene.rows[rows.a].instance}, InstanceId{scene.rows[rows.b].instance}};
}

} // namespace

Result<std::vector<InstancePair>> pairs_in_contact(const Scene& scene,
                                                   const ScenePairOptions& options)
{
    const SceneParts& parts = scene.parts();
    return find_pairs<InstancePair>(
        parts, BoxReach(0), options, [&](const PairRows& rows) -> std::optional<InstancePair> {
            const bool meet =
                meshes_intersect(parts.index(parts.rows[rows.a]), parts.index(parts.rows[rows.b]),
                                 relative_pose(parts.poses[rows.a], parts.poses[rows.b]));
            return meet ? std::optional(pair_of(parts, rows)) : std::nullopt;
        });
}

Result<std::vector<NearInstances>> pairs_within(const Scene& scene, double distance,
                                                const ScenePairOptions& options)
{
    if (Status status = check_distance(distance); !status) return tl::unexpected(status.error());
    const SceneParts& parts = scene.parts();
    // Poses change lengths by 2^-29 at most.
    const double most = distance * (1 + 0x1p-28);
    return find_pairs<NearInstances>(
        parts, BoxReach(most), options, [&](const PairRows& rows) -> std::optional<NearInstances> {
            const auto near =
                mesh_distance(parts.index(parts.rows[rows.a]), parts.index(parts.rows[rows.b]),
                              relative_pose(parts.poses[rows.a], parts.poses[rows.b]),
                              {.farthest = distance, .progress = options.execution.progress});
            if (!near || !(near->distance <= distance)) return std::nullopt;
            const auto [a, b] = pair_of(parts, rows);
            const RigidTransform& pose = parts.poses[rows.a];
            return NearInstances{a, b, *near, pose(near->point_a), pose(near->point_b)};
        });
}

Result<std::vector<InstancePair>> overlapping_bounds(const Scene& scene, double distance,
                                                     const ScenePairOptions& options)
{
    if (Status status = check_distance(distance); !status) return tl::unexpected(status.error());
    const SceneParts& parts = scene.parts();
    return find_pairs<InstancePair>(
        parts, BoxReach(distance), options,
        [&](const PairRows& rows) -> std::optional<InstancePair> { return pair_of(parts, rows); });
}

} // namespace proxima
