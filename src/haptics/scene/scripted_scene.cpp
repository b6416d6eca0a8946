#include "haptics/scene/scripted_scene.h"

#include "base/check.h"
#include "haptics/scene/touch_access.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

/// The scene's bounds are larger than those of the motions by this part: more than rounding.
constexpr double bounds_margin = 1e-6;

/// The farthest coordinate: squares and products of distances must be finite.
constexpr double farthest_reach = 1e100;

/// More than the rounding of a pose's corners, in parts of its coordinates and those of the mesh.
constexpr double pose_rounding = 0x1p-46;

/// `farthest` is the largest coordinate of meshes in their own frames and of poses.
Box bounds_about(const Box& bounds, double room, double farthest)
{
    const Vec3 beyond = Vec3::Constant(room * bounds.extent().norm());
    const Box reach = {bounds.lower - beyond, bounds.upper + beyond};
    const double margin =
        std::max(bounds_margin * std::max({reach.lower.cwiseAbs().maxCoeff(),
                                           reach.upper.cwiseAbs().maxCoeff(), 1e-300}),
                 pose_rounding * farthest);
    return {reach.lower - Vec3::Constant(margin), reach.upper + Vec3::Constant(margin)};
}

std::uint64_t ticks_per_update(double tick_seconds) noexcept
{
    return static_cast<std::uint64_t>(
        std::max(1LL, std::llround(seconds_per_update / tick_seconds)));
}

} // namespace

ScriptedScene::ScriptedScene(Box bounds, const Box& scene_bounds,
                             std::span<const ScriptedObject> objects)
    : bounds_(std::move(bounds)), scene_(scene_bounds), objects_(objects.begin(), objects.end())
{}

Result<std::unique_ptr<ScriptedScene>> ScriptedScene::make(std::span<const TouchBody> bodies,
                                                           std::span<const ScriptedObject> objects,
                                                           double room)
{
    PROXIMA_CHECK(room >= 0);
    PROXIMA_CHECK_EQ(bodies.size(), objects.size());
    PROXIMA_CHECK(!bodies.empty());
    Box reach;
    double farthest = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        const ScriptedObject& object = objects[i];
        if (Status status = check_script(object.script); !status)
            return tl::unexpected(status.error());
        const Box& local = contact_body(bodies[i]).bounds();
        const Box box = swept_bounds(object.script, object.pose, local);
        reach.extend(box.lower);
        reach.extend(box.upper);
        farthest = std::max({farthest, local.lower.cwiseAbs().maxCoeff(),
                             local.upper.cwiseAbs().maxCoeff(),
                             object.pose.translation.cwiseAbs().maxCoeff()});
    }
    const Box bounds = bounds_about(reach, room, farthest);
    farthest = std::max(
        {farthest, bounds.lower.cwiseAbs().maxCoeff(), bounds.upper.cwiseAbs().maxCoeff()});
    if (!(farthest <= farthest_reach)) {
        return fail(
            ErrorCode::invalid_argument,
            "an object is or moves too far from the origin: coordinates must be at most 1e100");
    }
    std::unique_ptr<ScriptedScene> scripted(new ScriptedScene(reach, bounds, objects));
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        const auto added = scripted->scene_.add(bodies[i], objects[i].pose);
        if (!added) return tl::unexpected(added.error());
    }
    return scripted;
}

void ScriptedScene::send_motions(std::uint64_t tick, double tick_seconds) noexcept
{
    const std::uint64_t ticks = ticks_per_update(tick_seconds);
    if (tick % ticks != 0) return;
    const double there = static_cast<double>(tick + ticks) * tick_seconds;
    for (std::uint32_t i = 0; i < objects_.size(); ++i) {
        const ScriptedObject& object = objects_[i];
        if (object.script.kind == ObjectMotionKind::rest) continue;
        const Vec3 middle = moving_surface(scene_).object(ObjectId{i}).body->bounds().center();
        const bool turns = object.script.kind != ObjectMotionKind::swing;
        const Status status = scene_views(scene_).input().move(
            ObjectId{i},
            {.pose = pose_at(object.script, object.pose, middle, there),
             .seconds = static_cast<double>(ticks) * tick_seconds},
            turns ? middle : Vec3(Vec3::Zero()));
        PROXIMA_CHECK(status.has_value()); // scripts stay within the bounds
    }
}

void ScriptedScene::rewind() noexcept
{
    for (std::uint32_t i = 0; i < objects_.size(); ++i) {
        const Status status = scene_.move(ObjectId{i}, {.pose = objects_[i].pose});
        PROXIMA_CHECK(status.has_value());
    }
    // One tick to arrive, one at rest.
    constexpr double seconds = 1e-3;
    (void)scene_.advance(seconds);
    (void)scene_.advance(seconds);
}

Result<TriangleMesh> scene_mesh(const TouchScene& scene)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < scene.object_count(); ++i) {
        const SceneObject object = moving_surface(scene).object(ObjectId{i});
        const TriangleMesh& mesh = object.body->mesh();
        const auto shift = static_cast<std::uint32_t>(positions.size());
        for (const Vec3& p : mesh.positions()) positions.push_back(object.now(p));
        for (const TriangleCorners& t : mesh.triangles())
            triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

} // namespace proxima
