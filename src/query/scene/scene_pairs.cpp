// Pairs of instances: each leaf of the tree looks for what is near its box, and each pair of instances is
// found by the leaf that comes first.
#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/visit_near.h"
#include "proxima/intersect_meshes.h"
#include "proxima/scene.h"
#include "query/scene/scene_parts.h"

#include <algorithm>
#include <atomic>
#include <cmath>

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

/// Calls visit(rows) for all pairs whose boxes are near enough and whose first row is in [first, end).
template <class Visit>
void visit_pairs_of(const SceneParts& scene, std::uint32_t first, std::uint32_t end,
                    const BoxReach& reach, const ScenePairOptions& options, const Visit& visit)
{
    const auto asks = [&](const SceneRow& row) {
        return (row.layers & (options.layers | options.others)) != 0;
    };
    Box box; // of some rows, neighbours in the tree
    constexpr std::uint32_t together = 4;
    for (std::uint32_t from = first; from < end; from += together) {
        const std::uint32_t to = std::min(end, from + together);
        box = {};
        for (std::uint32_t row = from; row < to; ++row) {
            if (!asks(scene.rows[row])) continue;
            box.extend(scene.rows[row].box.lower);
            box.extend(scene.rows[row].box.upper);
        }
        if (box.empty()) continue;
        NearWalk walk(scene.tree.parts(), box, reach.squared());
        while (const IndexLeaf* const leaf = walk.next_leaf()) {
            for (std::uint32_t other = std::max(leaf->first_row, from + 1);
                 other < leaf->first_row + leaf->count; ++other) {
                const SceneRow& b = scene.rows[other];
                for (std::uint32_t row = from; row < std::min(to, other); ++row) {
                    const SceneRow& a = scene.rows[row];
                    if (!reach.has(a.box, b.box) || !are_wanted(a, b, options)) continue;
                    visit(a.instance < b.instance ? PairRows{row, other} : PairRows{other, row});
                }
            }
        }
    }
}

/// All pairs for which ask(rows) has an answer, ascending. Errors: budget_exceeded, cancelled.
template <class Found, class Ask>
Result<std::vector<Found>> find_pairs(const SceneParts& scene, const BoxReach& reach,
                                      const ScenePairOptions& options, const Ask& ask)
{
    const Execution& execution = options.execution;
    begin_stage(execution.progress, "finding pairs", scene.tree_rows());
    std::vector<std::vector<Found>> found(chunk_count(scene.tree_rows(), rows_per_task));
    // Once in the tasks' lists, once in the answer.
    const std::uint64_t most = budget_bytes(execution.budget) / (2 * sizeof(Found));
    std::atomic<std::uint64_t> count = 0;
    parallel_chunks(scene.tree_rows(), rows_per_task, execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        if (is_cancelled(execution.progress) || count > most) return;
                        std::vector<Found>& own = found[first / rows_per_task];
                        visit_pairs_of(scene, static_cast<std::uint32_t>(first),
                                       static_cast<std::uint32_t>(end), reach, options,
                                       [&](const PairRows& rows) {
                                           if (is_cancelled(execution.progress) || count > most)
                                               return;
                                           auto answer = ask(rows);
                                           if (!answer) return;
                                           own.push_back(*answer);
                                           ++count;
                                       });
                        advance_stage(execution.progress, end - first);
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
