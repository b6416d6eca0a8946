#include "base/check.h"
#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "proxima/scene.h"
#include "query/scene/instance_box.h"
#include "query/scene/scene_parts.h"
#include "query/scene/scene_tree.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

namespace proxima {

namespace {

constexpr std::size_t instances_per_task = 1024;
constexpr std::uint64_t scene_bytes_each = 700;
/// Where more than one instance in so many moves, all boxes are drawn again.
constexpr std::size_t most_moved_share = 8;

/// Why a pose cannot be one of an instance; null where it can.
const char* pose_problem(const RigidTransform& pose) noexcept
{
    const Mat3& r = pose.rotation;
    if (!r.allFinite() || !pose.translation.allFinite())
        return "its pose has a number that is not finite";
    if (!((r.transpose() * r - Mat3::Identity()).norm() <= rigid_tolerance))
        return "its pose is not rigid; make it by make_rigid_transform";
    if (r.determinant() < 0) return "its pose mirrors; give a rotation";
    return nullptr;
}

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

/// Sets the box of an instance, empty for an empty shape. Why there is none; null where there is one.
const char* place(const std::vector<InstancedShape>& shapes, const Instance& instance,
                  Box& box) noexcept
{
    if (instance.shape >= shapes.size()) return "its shape is not one of the scene's indexes";
    if (const char* const problem = pose_problem(instance.pose); problem != nullptr) return problem;
    const InstancedShape& shape = shapes[instance.shape];
    if (shape.boxes.empty()) return nullptr;
    box = instance_box(shape, instance.pose);
    const bool fits = (box.lower.array() >= -max_scene_coordinate).all() &&
                      (box.upper.array() <= max_scene_coordinate).all() &&
                      instance.pose.translation.cwiseAbs().maxCoeff() <= max_scene_coordinate &&
                      shape.reach <= max_scene_coordinate;
    return fits ? nullptr : "it reaches beyond 2^500: scale the models or move them nearer";
}

/// Calls place_range(first, end, refuse) in parallel for all of [0, count); refuse(instance) says that this one is wrong.
/// Errors: invalid_argument with why(instance) for the lowest of these, cancelled.
template <class PlaceRange, class Why>
Status place_all(std::size_t count, const Execution& execution, const PlaceRange& place_range,
                 const Why& why)
{
    begin_stage(execution.progress, "placing instances", count);
    std::atomic<std::size_t> wrong = count;
    const auto refuse = [&](std::size_t instance) {
        std::size_t now = wrong;
        while (instance < now && !wrong.compare_exchange_weak(now, instance)) {
        }
    };
    parallel_chunks(count, instances_per_task, execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        if (is_cancelled(execution.progress)) return;
                        place_range(first, end, refuse);
                        advance_stage(execution.progress, end - first);
                    });
    if (is_cancelled(execution.progress)) return cancelled("placing instances");
    if (wrong == count) return {};
    return fail(ErrorCode::invalid_argument, why(wrong.load()), concat("instance ", wrong.load()));
}

/// The diagonals of boxes that are not empty, as triangles of two corners.
TriangleMesh diagonals_of(std::span<const Box> boxes)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    positions.reserve(2 * boxes.size());
    triangles.reserve(boxes.size());
    for (const Box& box : boxes) {
        const auto lower = static_cast<std::uint32_t>(positions.size());
        positions.push_back(box.lower);
        positions.push_back(box.upper);
        triangles.push_back({lower, lower + 1, lower + 1});
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles)).value();
}

/// Sets the tree about the rows, the first `full` of which have boxes, and what the scene knows of all of them. Error
/// cancelled.
Status finish_scene(SceneParts& parts, const IndexParts& order, std::size_t full,
                    const Execution& execution)
{
    Box& all = parts.all;
    double largest = 0;
    const std::span<const SceneRow> rows = std::span(parts.rows).first(full);
    for (const SceneRow& row : rows) {
        all.lower = all.lower.cwiseMin(row.box.lower);
        all.upper = all.upper.cwiseMax(row.box.upper);
        largest = std::max(largest, row.box.extent().maxCoeff());
    }
    parts.largest_extent = 2 * largest;
    parts.reach = 0;
    if (full == 0) return {};
    parts.reach = std::max(all.lower.cwiseAbs().maxCoeff(), all.upper.cwiseAbs().maxCoeff());
    begin_stage(execution.progress, "drawing boxes", 1);
    if (!draw_tree(parts, order, execution)) return cancelled("drawing boxes");
    advance_stage(execution.progress, 1);
    return {};
}

Status check_scene_budget(std::size_t instances, std::size_t shapes, const Execution& execution)
{
    constexpr std::uint64_t shape_bytes =
        sizeof(InstancedShape) + most_shape_boxes / 8 * sizeof(ShapeBoxes);
    return check_budget(execution.budget, scene_bytes_each * instances + shape_bytes * shapes,
                        "the scene", "take fewer instances or shapes, or raise the budget");
}

} // namespace

RigidTransform instance_frame(const RigidTransform& pose) noexcept
{
    RigidTransform frame;
    const Mat3& r = pose.rotation;
    const Vec3& t = pose.translation;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) frame.rotation(i, j) = r(j, i);
        frame.translation[i] = -((r(0, i) * t[0] + r(1, i) * t[1]) + r(2, i) * t[2]);
    }
    return frame;
}

RigidTransform relative_pose(const RigidTransform& a, const RigidTransform& b) noexcept
{
    RigidTransform pose;
    const auto turned_back = [&](const double* v, int i) {
        return (a.rotation(0, i) * v[0] + a.rotation(1, i) * v[1]) + a.rotation(2, i) * v[2];
    };
    const Vec3 between(b.translation[0] - a.translation[0], b.translation[1] - a.translation[1],
                       b.translation[2] - a.translation[2]);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const Vec3 column(b.rotation(0, j), b.rotation(1, j), b.rotation(2, j));
            pose.rotation(i, j) = turned_back(column.data(), i);
        }
        pose.translation[i] = turned_back(between.data(), i);
    }
    return pose;
}

Ray to_instance(const RigidTransform& pose, const Ray& ray) noexcept
{
    RigidTransform frame = instance_frame(pose);
    Ray moved = ray;
    moved.origin = frame(ray.origin);
    frame.translation.setZero();
    moved.direction = frame(ray.direction);
    return moved;
}

ViewPlane to_instance(const RigidTransform& pose, const ViewPlane& plane) noexcept
{
    RigidTransform frame = instance_frame(pose);
    frame.translation.setZero();
    const Vec3& n = plane.normal;
    const Vec3& t = pose.translation;
    return {frame(n), ((n[0] * t[0] + n[1] * t[1]) + n[2] * t[2]) + plane.offset};
}

Scene::Scene()
{
    auto parts = std::make_shared<SceneParts>();
    parts->shapes = std::make_shared<const std::vector<InstancedShape>>();
    parts->row_of = std::make_shared<const std::vector<std::uint32_t>>();
    parts_ = std::move(parts);
}

Scene::Scene(std::shared_ptr<const SceneParts> parts) noexcept : parts_(std::move(parts))
{
    PROXIMA_CHECK(parts_ != nullptr);
}

std::size_t Scene::instance_count() const noexcept
{
    return parts_->rows.size();
}

std::size_t Scene::shape_count() const noexcept
{
    return parts_->shapes->size();
}

const MeshIndex& Scene::shape(std::uint32_t shape) const noexcept
{
    PROXIMA_CHECK_LT(shape, shape_count());
    return (*parts_->shapes)[shape].index;
}

Instance Scene::instance(InstanceId id) const noexcept
{
    PROXIMA_CHECK_LT(to_index(id), instance_count());
    const std::uint32_t at = (*parts_->row_of)[to_index(id)];
    const SceneRow& row = parts_->rows[at];
    return {row.shape, parts_->poses[at], row.layers};
}

Box Scene::bounds(InstanceId id) const noexcept
{
    PROXIMA_CHECK_LT(to_index(id), instance_count());
    return parts_->rows[(*parts_->row_of)[to_index(id)]].box;
}

std::uint64_t Scene::bytes() const noexcept
{
    const std::size_t each = sizeof(SceneRow) + sizeof(RigidTransform) + sizeof(std::uint32_t);
    std::uint64_t bytes = parts_->tree.bytes() + each * parts_->rows.size() +
                          sizeof(SceneBlock) * parts_->boxes.size();
    for (const InstancedShape& shape : *parts_->shapes)
        bytes += sizeof(InstancedShape) + shape.boxes.capacity() * sizeof(ShapeBoxes);
    return bytes;
}

Result<Scene> build_scene(std::span<const MeshIndex> shapes, std::span<const Instance> instances,
                          const SceneOptions& options)
{
    const Execution& execution = options.execution;
    if (instances.size() > max_instances) {
        return fail(ErrorCode::limit_exceeded,
                    concat("a scene has at most ", max_instances, " instances, this one has ",
                           instances.size()));
    }
    if (Status status = check_scene_budget(instances.size(), shapes.size(), execution); !status)
        return tl::unexpected(status.error());
    auto parts = std::make_shared<SceneParts>();
    std::vector<InstancedShape> made(shapes.size());
    begin_stage(execution.progress, "measuring shapes", shapes.size());
    parallel_for(shapes.size(), execution.threads, [&](std::size_t i) {
        made[i] = make_instanced_shape(shapes[i], execution.progress);
        advance_stage(execution.progress, 1);
    });
    if (is_cancelled(execution.progress)) return cancelled("measuring shapes");
    std::vector<Box> boxes(instances.size()); // by instance
    const Status placed = place_all(
        instances.size(), execution,
        [&](std::size_t first, std::size_t end, const auto& refuse) {
            for (std::size_t i = first; i < end; ++i)
                if (place(made, instances[i], boxes[i]) != nullptr) return refuse(i);
        },
        [&](std::size_t i) { return place(made, instances[i], boxes[i]); });
    if (!placed) return tl::unexpected(placed.error());
    std::vector<std::uint32_t> ids; // of instances that have a box, then of the others
    std::vector<Box> full;
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
        if (boxes[i].empty()) continue;
        ids.push_back(i);
        full.push_back(boxes[i]);
    }
    MeshIndex order;
    if (!full.empty()) {
        auto tree = build_mesh_index(diagonals_of(full), {.execution = execution});
        if (!tree) return tl::unexpected(tree.error());
        order = *tree;
    }
    std::vector<std::uint32_t> row_of(instances.size());
    parts->rows.resize(instances.size());
    parts->poses.resize(instances.size());
    const auto put = [&](std::uint32_t row, std::uint32_t id) {
        row_of[id] = row;
        parts->rows[row] = {boxes[id], instances[id].layers, id, instances[id].shape, 0};
        parts->poses[row] = instances[id].pose;
    };
    std::uint32_t row = 0;
    for (const TriangleId at : order.ids()) put(row++, ids[to_index(at)]);
    for (std::uint32_t i = 0; i < boxes.size(); ++i)
        if (boxes[i].empty()) put(row++, i);
    parts->shapes = std::make_shared<const std::vector<InstancedShape>>(std::move(made));
    parts->row_of = std::make_shared<const std::vector<std::uint32_t>>(std::move(row_of));
    if (Status status = finish_scene(*parts, order.parts(), full.size(), execution); !status)
        return tl::unexpected(status.error());
    return Scene(std::move(parts));
}

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
        [&](std::size_t first, std::size_t end, const auto& refuse) {
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

Status move_instances(Scene& scene, std::span<const InstanceId> ids,
                      std::span<const RigidTransform> poses, const SceneOptions& options)
{
    const SceneParts& old = scene.parts();
    if (poses.size() != ids.size()) {
        return fail(ErrorCode::invalid_argument,
                    concat("a list of ", poses.size(), " poses, but ", ids.size(),
                           " instances; give one for each"));
    }
    for (const InstanceId id : ids) {
        if (to_index(id) >= old.rows.size()) {
            return fail(ErrorCode::invalid_argument,
                        concat("there is no such instance: the scene has ", old.rows.size()),
                        concat("instance ", to_index(id)));
        }
    }
    const auto row_of = [&](InstanceId id) { return (*old.row_of)[to_index(id)]; };
    std::vector<Box> boxes(ids.size());
    std::vector<std::uint32_t> moved; // rows of the tree
    bool is_within = ids.size() <= old.rows.size() / most_moved_share;
    for (std::size_t i = 0; i < ids.size() && is_within; ++i) {
        const SceneRow& row = old.rows[row_of(ids[i])];
        const char* const problem = place(*old.shapes, {row.shape, poses[i], row.layers}, boxes[i]);
        if (problem != nullptr)
            return fail(ErrorCode::invalid_argument, problem, concat("instance ", row.instance));
        if (boxes[i].empty()) continue;
        is_within = (boxes[i].lower.array() >= old.all.lower.array()).all() &&
                    (boxes[i].upper.array() <= old.all.upper.array()).all();
        moved.push_back(row_of(ids[i]));
    }
    if (!is_within) { // the tree needs another frame, or there is little that stays
        std::vector<RigidTransform> all(old.rows.size());
        for (std::size_t i = 0; i < all.size(); ++i) all[old.rows[i].instance] = old.poses[i];
        for (std::size_t i = 0; i < ids.size(); ++i) all[to_index(ids[i])] = poses[i];
        auto next = move_instances(std::as_const(scene), all, options);
        if (!next) return tl::unexpected(next.error());
        scene = *next;
        return {};
    }
    if (scene.parts_.use_count() > 1) {
        if (Status status = check_scene_budget(old.rows.size(), 0, options.execution); !status)
            return status;
        scene.parts_ = std::make_shared<SceneParts>(copy_of(old));
    } else {
        // What other threads read of copies that they let go was before this.
        std::atomic_thread_fence(std::memory_order_acquire);
    }
    // No one else has it, and none was made const.
    SceneParts& parts = const_cast<SceneParts&>(*scene.parts_); // NOLINT
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const std::uint32_t row = (*parts.row_of)[to_index(ids[i])];
        parts.poses[row] = poses[i];
        if (boxes[i].empty()) continue;
        parts.rows[row].box = boxes[i];
        parts.largest_extent = std::max(parts.largest_extent, 2 * boxes[i].extent().maxCoeff());
    }
    if (!moved.empty()) redraw_tree(parts, moved);
    return {};
}

} // namespace proxima
