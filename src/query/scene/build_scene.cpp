#include "base/check.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "proxima/scene.h"
#include "query/scene/instance_box.h"
#include "query/scene/place_instances.h"
#include "query/scene/scene_parts.h"

#include <utility>

namespace proxima {

namespace {

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

} // namespace

RigidTransform instance_frame(const RigidTransform& pose) noexcept
{
    RigidTransform frame;
    const Mat3& r = pose.rotation;
    const Vec3& t = pose.translation;
    frame.rotation = r.transpose();
    for (int i = 0; i < 3; ++i)
        frame.translation[i] = -((r(0, i) * t[0] + r(1, i) * t[1]) + r(2, i) * t[2]);
    return frame;
}

RigidTransform relative_pose(const RigidTransform& a, const RigidTransform& b) noexcept
{
    const auto turned_back = [&](const Vec3& v) {
        Vec3 turned;
        for (int i = 0; i < 3; ++i) {
            turned[i] =
                (a.rotation(0, i) * v[0] + a.rotation(1, i) * v[1]) + a.rotation(2, i) * v[2];
        }
        return turned;
    };
    RigidTransform pose;
    for (int j = 0; j < 3; ++j) pose.rotation.col(j) = turned_back(b.rotation.col(j));
    pose.translation = turned_back(b.translation - a.translation);
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

} // namespace proxima
