#include "base/progress.h"
#include "base/text.h"
#include "index/index_parts.h"
#include "proxima/scene.h"
#include "query/scene/place_instances.h"
#include "query/scene/scene_parts.h"
#include "query/scene/scene_tree.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <memory>
#include <utility>

namespace proxima {

namespace {

/// Where more than one instance in so many moves, all boxes are drawn again.
constexpr std::size_t most_moved_share = 8;

bool same_bits(const RigidTransform& a, const RigidTransform& b) noexcept
{
    const auto bits = [](const double* numbers, std::size_t i) {
        return std::bit_cast<std::uint64_t>(numbers[i]);
    };
    std::uint64_t different = 0;
    for (std::size_t i = 0; i < 9; ++i)
        different |= bits(a.rotation.data(), i) ^ bits(b.rotation.data(), i);
    for (std::size_t i = 0; i < 3; ++i)
        different |= bits(a.translation.data(), i) ^ bits(b.translation.data(), i);
    return different == 0;
}

/// Instances that move, to these poses.
struct MovedInstances {
    std::span<const InstanceId> ids;
    std::span<const RigidTransform> poses;
};

/// Where some instances are to be.
struct MovedBoxes {
    std::vector<Box> boxes;          ///< by moved instance; empty for those of empty indexes
    std::vector<std::uint32_t> rows; ///< of the others
    /// Whether the tree can stay as it is but for boxes.
    bool are_within = true;
};

Status check_moved(const SceneParts& parts, const MovedInstances& moved)
{
    if (moved.poses.size() != moved.ids.size()) {
        return fail(ErrorCode::invalid_argument,
                    concat("a list of ", moved.poses.size(), " poses, but ", moved.ids.size(),
                           " instances; give one for each"));
    }
    for (const InstanceId id : moved.ids) {
        if (to_index(id) >= parts.rows.size()) {
            return fail(ErrorCode::invalid_argument,
                        concat("there is no such instance: the scene has ", parts.rows.size()),
                        concat("instance ", to_index(id)));
        }
    }
    return {};
}

/// Whether the instances take less than half of the box that the tree's frame is about, as when one came
/// back from far away: boxes are coarse then.
bool has_shrunk(const SceneParts& parts) noexcept
{
    if (parts.tree_rows() == 0) return false;
    const IndexParts& tree = parts.tree.parts();
    const FloatBox& root = parts.boxes[tree.root() & ~index_leaf_bit].box;
    double extent = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        extent = std::max(extent, double{root.upper[axis]} - double{root.lower[axis]});
    return extent < 0.5 * parts.all.extent().maxCoeff() * tree.scale();
}

Result<MovedBoxes> place_moved(const SceneParts& parts, const MovedInstances& moved,
                               Progress* progress)
{
    StageSteps steps(progress, "placing instances", moved.ids.size(), 1024);
    MovedBoxes to;
    to.are_within = moved.ids.size() <= parts.rows.size() / most_moved_share && !has_shrunk(parts);
    to.boxes.resize(moved.ids.size());
    to.rows.reserve(moved.ids.size());
    for (std::size_t i = 0; i < moved.ids.size(); ++i) {
        if (!steps.done(1)) return cancelled("placing instances");
        const std::uint32_t at = (*parts.row_of)[to_index(moved.ids[i])];
        const SceneRow& row = parts.rows[at];
        Box& box = to.boxes[i];
        const char* const problem =
            place(*parts.shapes, {row.shape, moved.poses[i], row.layers}, box);
        if (problem != nullptr)
            return fail(ErrorCode::invalid_argument, problem, concat("instance ", row.instance));
        if (box.empty()) continue;
        to.are_within = to.are_within && (box.lower.array() >= parts.all.lower.array()).all() &&
                        (box.upper.array() <= parts.all.upper.array()).all();
        to.rows.push_back(at);
    }
    if (is_cancelled(progress)) return cancelled("placing instances");
    return to;
}

/// The scene with a tree that is drawn anew.
Result<Scene> move_anew(const Scene& scene, const MovedInstances& moved,
                        const SceneOptions& options)
{
    const SceneParts& parts = scene.parts();
    std::vector<RigidTransform> poses(parts.rows.size());
    for (std::size_t i = 0; i < poses.size(); ++i) poses[parts.rows[i].instance] = parts.poses[i];
    for (std::size_t i = 0; i < moved.ids.size(); ++i)
        poses[to_index(moved.ids[i])] = moved.poses[i];
    return move_instances(scene, poses, options);
}

/// Makes the parts no one else's, by a copy where others have them. Error budget_exceeded.
Status own_parts(std::shared_ptr<const SceneParts>& parts, const Execution& execution)
{
    if (parts.use_count() > 1) {
        if (Status status = check_scene_budget(parts->rows.size(), 0, execution); !status)
            return status;
        parts = std::make_shared<SceneParts>(copy_of(*parts));
    } else {
        // What other threads read of copies that they let go was before this.
        std::atomic_thread_fence(std::memory_order_acquire);
    }
    return {};
}

/// `tree` is memory for what redraw_tree writes: nothing can fail here.
void write_moved(SceneParts& parts, const MovedInstances& moved, const MovedBoxes& to,
                 std::shared_ptr<IndexParts> tree) noexcept
{
    for (std::size_t i = 0; i < moved.ids.size(); ++i) {
        const std::uint32_t row = (*parts.row_of)[to_index(moved.ids[i])];
        parts.poses[row] = moved.poses[i];
        if (to.boxes[i].empty()) continue;
        parts.rows[row].box = to.boxes[i];
        parts.largest_extent = std::max(parts.largest_extent, 2 * to.boxes[i].extent().maxCoeff());
    }
    if (!to.rows.empty()) redraw_tree(parts, to.rows, std::move(tree));
}

} // namespace

Result<Scene> move_instances(const Scene& scene, std::span<const RigidTransform> poses,
                             const SceneOptions& options)
{
    const Execution& execution = options.execution;
    const SceneParts& old = scene.parts();
    if (poses.size() != old.rows.size()) {
        return fail(ErrorCode::invalid_argument,
                    concat("a list of ", poses.size(), " poses, but ", old.rows.size(),
                           " instances; give one for each"));
    }
    if (Status status = check_scene_budget(poses.size(), 0, execution); !status)
        return tl::unexpected(status.error());
    auto parts = std::make_shared<SceneParts>();
    parts->shapes = old.shapes;
    parts->row_of = old.row_of;
    parts->rows.resize(old.rows.size());
    parts->poses.resize(old.rows.size());
    const auto instance_of = [&](const SceneRow& row) {
        return Instance{row.shape, poses[row.instance], row.layers};
    };
    const Status placed = place_all(
        old.rows.size(), execution,
        [&](std::size_t first, std::size_t end, const Refuse& refuse) {
            for (std::size_t i = first; i < end; ++i) {
                // Rows are in the tree's order, poses are not.
                const auto ahead = old.rows[std::min(i + 8, end - 1)].instance;
                __builtin_prefetch(&poses[ahead].rotation);
                __builtin_prefetch(&poses[ahead].translation);
                SceneRow& row = parts->rows[i];
                row = old.rows[i];
                const RigidTransform& pose = poses[row.instance];
                parts->poses[i] = pose;
                if (same_bits(pose, old.poses[i])) continue; // nor has its box moved
                if (place(*old.shapes, instance_of(row), row.box) != nullptr) refuse(row.instance);
            }
        },
        [&](std::size_t id) {
            Box box;
            return place(*old.shapes, instance_of(old.rows[(*old.row_of)[id]]), box);
        });
    if (!placed) return tl::unexpected(placed.error());
    if (Status status = finish_scene(*parts, old.tree.parts(), old.tree_rows(), execution); !status)
        return tl::unexpected(status.error());
    return Scene(std::move(parts));
}

Status move_in_place(Scene& scene, std::span<const InstanceId> ids,
                     std::span<const RigidTransform> poses, const SceneOptions& options)
{
    const MovedInstances moved{ids, poses};
    if (Status status = check_moved(scene.parts(), moved); !status) return status;
    if (ids.empty()) return {};
    const Result<MovedBoxes> to = place_moved(scene.parts(), moved, options.execution.progress);
    if (!to) return tl::unexpected(to.error());
    if (!to->are_within) {
        const Result<Scene> next = move_anew(scene, moved, options);
        if (!next) return tl::unexpected(next.error());
        scene = *next;
        return {};
    }
    auto tree = std::make_shared<IndexParts>();
    if (Status status = own_parts(scene.parts_, options.execution); !status) return status;
    // No one else has them, and none were made const.
    write_moved(const_cast<SceneParts&>(*scene.parts_), moved, *to, std::move(tree)); // NOLINT
    return {};
}

} // namespace proxima
