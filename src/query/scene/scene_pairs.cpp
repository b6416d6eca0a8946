// Pairs of instances: the tree is walked against itself, and each pair of instances is found by the one whose row
// comes first.
#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/index_parts.h"
#include "proxima/intersect_meshes.h"
#include "proxima/scene.h"
#include "query/scene/scene_parts.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace proxima {

namespace {

constexpr std::size_t rows_per_task = 64;

/// How near boxes must be.
class BoxReach {
public:
    BoxReach(const SceneParts& scene, double distance) noexcept
        : distance_(distance), in_tree_(distance * scene.tree.parts().scale())
    {}
    /// In units of the tree, for walks, which take more than its square loses by underflow.
    [[nodiscard]] double squared() const noexcept { return in_tree_ * in_tree_; }

    [[nodiscard]] bool has(const Box& a, const Box& b) const noexcept
    {
        Vec3 gaps;
        for (int axis = 0; axis < 3; ++axis) {
            gaps[axis] =
                std::max({a.lower[axis] - b.upper[axis], b.lower[axis] - a.upper[axis], 0.0});
        }
        if ((gaps.array() == 0).all()) return true;
        // In units of the distance: squares of very small numbers are zero.
        return distance_ > 0 && (gaps / distance_).squaredNorm() <= 1 + 0x1p-50;
    }

private:
    double distance_;
    double in_tree_;
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

/// A block of the tree, its box in the tree's units, and its rows.
struct PairBlock {
    std::uint32_t reference;
    std::uint32_t first;
    std::uint32_t end;
    std::array<double, 3> lower;
    std::array<double, 3> upper;

    [[nodiscard]] bool is_leaf() const noexcept { return (reference & index_leaf_bit) != 0; }
    [[nodiscard]] double size() const noexcept
    {
        return (upper[0] - lower[0]) + (upper[1] - lower[1]) + (upper[2] - lower[2]);
    }
};

/// Walks the tree against itself: pairs of blocks that are near each other, the larger one opened.
class PairWalkOfScene {
public:
    PairWalkOfScene(const SceneParts& scene, const BoxReach& reach) noexcept
        : scene_(scene), tree_(scene.tree.parts()), reach_(reach),
          most_(reach.squared() * (1 + 0x1p-40) + std::numeric_limits<double>::min())
    {}

    [[nodiscard]] PairBlock root() const noexcept
    {
        return {tree_.root(), 0, scene_.tree_rows(), {-2, -2, -2}, {2, 2, 2}};
    }

    /// Calls visit(child) for the children of a node, by their rows.
    template <class Visit>
    void open(const PairBlock& at, const Visit& visit) const
    {
        const IndexNode& node = tree_.blocks()[at.reference].node;
        const auto count = 8 - static_cast<std::uint32_t>(std::countl_one(node.order)) / 4;
        PairBlock child = {};
        child.end = at.end;
        for (std::uint32_t i = count; i-- > 0; child.end = child.first) {
            const std::uint32_t slot = node.order >> (4 * i) & 15U;
            child.reference = node.children[slot];
            child.first = first_row(node, slot);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                child.lower[axis] = node.plane(axis, slot);
                child.upper[axis] = node.plane(axis, 8 + slot);
            }
            visit(child);
        }
    }

    /// Calls visit(row, other) for all pairs whose boxes are near enough, row below `top` and other behind it.
    template <class Visit>
    void walk(const PairBlock& top, const Visit& visit)
    {
        pending_.assign(1, {top, root()});
        while (!pending_.empty()) {
            const auto [a, b] = pending_.back();
            pending_.pop_back();
            if (a.is_leaf() && b.is_leaf()) {
                visit_rows(a, b, visit);
            } else if (b.is_leaf() || (!a.is_leaf() && a.size() >= b.size())) {
                open(a, [&](const PairBlock& child) { push(child, b); });
            } else {
                open(b, [&](const PairBlock& child) { push(a, child); });
            }
        }
    }

private:
    [[nodiscard]] std::uint32_t first_row(const IndexNode& node, std::uint32_t slot) const noexcept
    {
        if (node.starts[slot] != IndexNode::far_start) return node.first_row + node.starts[slot];
        const std::uint32_t reference = node.children[slot];
        const IndexBlock& block = tree_.blocks()[reference & ~index_leaf_bit];
        return (reference & index_leaf_bit) != 0 ? block.leaf.first_row : block.node.first_row;
    }

    void push(const PairBlock& a, const PairBlock& b)
    {
        if (b.end <= a.first + 1) return;
        double squared = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double gap = std::max(
                std::max(a.lower[axis] - b.upper[axis], b.lower[axis] - a.upper[axis]), 0.0);
            squared += gap * gap;
        }
        if (squared <= most_) pending_.push_back({a, b});
    }

    template <class Visit>
    void visit_rows(const PairBlock& a, const PairBlock& b, const Visit& visit) const
    {
        for (std::uint32_t row = a.first; row < a.end; ++row) {
            for (std::uint32_t other = std::max(b.first, row + 1); other < b.end; ++other)
                if (reach_.has(scene_.rows[row].box, scene_.rows[other].box)) visit(row, other);
        }
    }

    const SceneParts& scene_;
    const IndexParts& tree_;
    const BoxReach& reach_;
    double most_;
    std::vector<std::pair<PairBlock, PairBlock>> pending_;
};

/// Blocks of at most rows_per_task rows, or leaves, that have all rows.
std::vector<PairBlock> tops_of(const SceneParts& scene, const BoxReach& reach)
{
    std::vector<PairBlock> tops;
    if (scene.tree_rows() == 0) return tops;
    const PairWalkOfScene walk(scene, reach);
    std::vector<PairBlock> pending = {walk.root()};
    while (!pending.empty()) {
        const PairBlock at = pending.back();
        pending.pop_back();
        if (at.is_leaf() || at.end - at.first <= rows_per_task) {
            tops.push_back(at);
        } else {
            walk.open(at, [&](const PairBlock& child) { pending.push_back(child); });
        }
    }
    return tops;
}

/// All pairs for which ask(rows) has an answer, ascending. Errors: budget_exceeded, cancelled.
template <class Found, class Ask>
Result<std::vector<Found>> find_pairs(const SceneParts& scene, const BoxReach& reach,
                                      const ScenePairOptions& options, const Ask& ask)
{
    const Execution& execution = options.execution;
    begin_stage(execution.progress, "finding pairs", scene.tree_rows());
    const std::vector<PairBlock> tops = tops_of(scene, reach);
    std::vector<std::vector<Found>> found(tops.size());
    // Once in the tasks' lists, once in the answer.
    const std::uint64_t most = budget_bytes(execution.budget) / (2 * sizeof(Found));
    std::atomic<std::uint64_t> count = 0;
    const auto is_over = [&] { return is_cancelled(execution.progress) || count > most; };
    parallel_for(tops.size(), execution.threads, [&](std::size_t task) {
        if (is_over()) return;
        PairWalkOfScene walk(scene, reach);
        walk.walk(tops[task], [&](std::uint32_t row, std::uint32_t other) {
            const SceneRow& a = scene.rows[row];
            const SceneRow& b = scene.rows[other];
            if (!are_wanted(a, b, options) || is_over()) return;
            const auto answer =
                ask(a.instance < b.instance ? PairRows{row, other} : PairRows{other, row});
            if (!answer) return;
            found[task].push_back(*answer);
            ++count;
        });
        advance_stage(execution.progress, tops[task].end - tops[task].first);
    });
    if (is_cancelled(execution.progress)) return cancelled("finding pairs");
    if (count > most) {
        return fail(ErrorCode::budget_exceeded,
                    concat("there are more than ", most,
                           " pairs, which the memory budget does not hold; take fewer instances, a "
                           "smaller distance or layers, or raise the budget"));
    }
    std::vector<Found> all;
    all.reserve(count);
    for (std::vector<Found>& own : found) {
        all.insert(all.end(), own.begin(), own.end());
        own = {};
    }
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
        parts, {parts, 0}, options, [&](const PairRows& rows) -> std::optional<InstancePair> {
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
        parts, {parts, most}, options, [&](const PairRows& rows) -> std::optional<NearInstances> {
            const auto near = mesh_distance(
                parts.index(parts.rows[rows.a]), parts.index(parts.rows[rows.b]),
                relative_pose(parts.poses[rows.a], parts.poses[rows.b]), {.farthest = distance});
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
        parts, {parts, distance}, options,
        [&](const PairRows& rows) -> std::optional<InstancePair> { return pair_of(parts, rows); });
}

} // namespace proxima
