// Scenes that tests touch, their triangles as one mesh, and motions checked against every triangle.
#pragma once

#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"
#include "geometry/triangle_contact.h"
#include "haptics/scene/object_trajectory.h"
#include "haptics/scene/touch_access.h"
#include "haptics/touch_meshes.h"
#include "proxima/touch_scene.h"

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <utility>

namespace proxima::testing {

inline const Box wide_room{Vec3(-20, -20, -20), Vec3(20, 20, 20)};

inline RigidTransform posed(double angle, const Vec3& axis, const Vec3& to)
{
    return {Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), to};
}

inline RigidTransform at_place(const Vec3& to)
{
    return {Mat3::Identity(), to};
}

inline TouchBody body_of(TriangleMesh mesh, const TouchBodyOptions& options = {},
                         BodySearch search = BodySearch::index)
{
    return TouchAccess::wrap(std::move(*build_contact_body(std::move(mesh), options, search)));
}

/// A box between -half and half.
inline TriangleMesh box_mesh(const Vec3& half)
{
    return moved(*sample_mesh("cube"), [&](const Vec3& p) { return Vec3(p.cwiseProduct(half)); });
}

/// Whether a point that goes straight meets any triangle that has an area.
inline bool passes(const TriangleMesh& mesh, const Vec3& from, const Vec3& to)
{
    if (from == to) return false;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const Triangle triangle = mesh.triangle(TriangleId{id});
        if (!is_degenerate(triangle) && segment_meets_triangle(from, to, triangle)) return true;
    }
    return false;
}

/// Whether a point that goes straight in the object's frame meets any of its triangles.
inline bool passes_object(const SceneObject& object, const Vec3& from, const Vec3& to)
{
    return passes(object.body->mesh(), from, to);
}

/// Whether a point that goes from one place to another, while the objects go from where they stood
/// to where they are, passes any of them, straight as each of them sees it.
inline bool passes_while_moving(const TouchScene& scene, const Vec3& from, const Vec3& to)
{
    for (std::uint32_t i = 0; i < scene.object_count(); ++i) {
        const SceneObject object = moving_surface(scene).object(ObjectId{i});
        if (passes_object(object, to_local(object.before, from), to_local(object.now, to)))
            return true;
    }
    return false;
}

/// The same while they stand where they are.
inline bool passes_standing(const TouchScene& scene, const Vec3& from, const Vec3& to)
{
    for (std::uint32_t i = 0; i < scene.object_count(); ++i) {
        const SceneObject object = moving_surface(scene).object(ObjectId{i});
        if (passes_object(object, to_local(object.now, from), to_local(object.now, to)))
            return true;
    }
    return false;
}

/// Of all triangles, as they stand.
inline double distance_of(const TouchScene& scene, const Vec3& p)
{
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < scene.object_count(); ++i) {
        const SceneObject object = moving_surface(scene).object(ObjectId{i});
        const TriangleMesh& mesh = object.body->mesh();
        const Vec3 local = to_local(object.now, p);
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const TrianglePoint closest = closest_point(mesh.triangle(TriangleId{id}), local);
            least = std::min(least, (closest.point - local).norm());
        }
    }
    return least;
}

} // namespace proxima::testing
