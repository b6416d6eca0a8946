#include "query/scene/place_instances.h"

#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"
#include "query/scene/instance_box.h"
#include "query/scene/scene_tree.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <span>

namespace proxima {

namespace {

constexpr std::size_t instances_per_task = 1024;
constexpr std::uint64_t scene_bytes_each = 700;

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

} // namespace

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

Status place_all(std::size_t count, const Execution& execution,
                 FunctionRef<void(std::size_t first, std::size_t end, Refuse refuse)> place_range,
                 FunctionRef<const char*(std::size_t instance)> why)
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

} // namespace proxima
