#include "haptics/scene/move_with_objects.h"

#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"
#include "haptics/scene/object_trajectory.h"
#include "haptics/surface/swept_sphere.h"
#include "proxima/touch_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace proxima {

namespace {

/// Thickness of the skin relative to the size of coordinates, equal to that of slides.
constexpr double skin_part = 0x1p-42;

/// Triangles are collected within so many more mean edges of a path, for the next path is similar.
constexpr double slack_in_edges = 0.05;

/// A proxy that a changing shape carries is no farther above it.
constexpr double lift_in_edges = 0.05;

/// Where the triangle takes a sphere that touches it or is a little above it, in the object's frame:
/// to the same point of it, and as far away as its radius.
Vec3 taken_position(const MovingTriangle& triangle, double radius, const Vec3& p) noexcept
{
    const TrianglePoint at = closest_point(triangle.before, p);
    const Vec3 point = point_at(triangle.now, at.weights);
    const Vec3 away = p - at.point;
    const double distance = away.norm();
    if (at.part != TrianglePart::inside && distance > 0) return point + away * (radius / distance);
    const Vec3 normal = unit_normal(triangle.now);
    const double side = unit_normal(triangle.before).dot(away) < 0 ? -radius : radius;
    return point + side * normal;
}

} // namespace

/// One call of move_with_objects().
class Carry {
public:
    Carry(const MovingSurface& scene, double radius, Vec3 from, Vec3 goal,
          CarryScratch& scratch) noexcept
        : scene_(scene), radius_(radius), skin_(skin_part * scene.scale().reach),
          from_(std::move(from)), goal_(std::move(goal)), scratch_(scratch)
    {}

    std::optional<Vec3> run() noexcept
    {
        for (std::size_t round = 0; round < max_contact_planes; ++round) {
            const auto planes = std::span(scratch_.planes_).first(count_);
            const PlaneSolution solution = nearest_allowed(planes, skin_ / 8);
            if (!solution.feasible) return std::nullopt;
            const Vec3 position = goal_ + solution.shift;
            bool blocked = false;
            for (std::uint32_t i = 0; i < scene_.object_count(); ++i) {
                if (!begin_sweep(ObjectId{i}, position, blocked)) return std::nullopt;
            }
            if (!blocked) return position;
        }
        return std::nullopt;
    }

    /// Where an object whose shape changed takes a position of its frame: with the nearest triangle,
    /// and onto it, or as far as its contact where no triangle is near, or more than there is memory for.
    static Vec3 taken(const MovingSurface& scene, TriangleId contact, double radius, const Vec3& p,
                      CarryScratch& scratch) noexcept
    {
        const ObjectId id = object_of(contact);
        const double edge = scene.object(id).body->surface().scale().mean_edge;
        const std::size_t found = scene.collect_changing(
            id, p, Vec3::Zero(), radius + lift_in_edges * edge, scratch.near_, scratch.changing_);
        const MovingTriangle* nearest = nullptr;
        double least = std::numeric_limits<double>::infinity();
        const std::size_t count = found <= scratch.changing_.size() ? found : 0;
        for (const MovingTriangle& triangle : std::span(scratch.changing_).first(count)) {
            const double squared = (closest_point(triangle.before, p).point - p).squaredNorm();
            if (squared > least || (squared == least && nearest->id < triangle.id)) continue;
            least = squared;
            nearest = &triangle;
        }
        if (nearest != nullptr) return taken_position(*nearest, radius, p);
        const MovingTriangle held_by = scene.changing_triangle(contact);
        const TrianglePoint at = closest_point(held_by.before, p);
        return p + (point_at(held_by.now, at.weights) - at.point);
    }

private:
    /// Adds the planes of an object on the path to `position`. False where there are too many.
    bool begin_sweep(ObjectId id, const Vec3& position, bool& blocked) noexcept
    {
        const double reach = radius_ + 2 * skin_;
        if (scene_.keeps_clear(id, from_, position, reach)) return true;
        const SceneObject object = scene_.object(id);
        const Vec3 begin = to_local(object.before, from_);
        const Vec3 motion = to_local(object.now, position) - begin;
        if (object.changed) return begin_changing_sweep(id, object, begin, motion, blocked);
        if (!collect(id, object, begin, motion, reach)) return false;
        double first = 2;
        const ContactTriangle* wall = nullptr;
        std::size_t touched = 0;
        for (const ContactTriangle& triangle : std::span(scratch_.near_).first(near_count_)) {
            const double least = least_touch_time(triangle.corners, reach, begin, motion);
            if (least > std::min(first, 1.0) || is_wall(scene_triangle(id, triangle.id))) continue;
            if (least == 0) {
                const CarryScratch::Side side = side_of(triangle, begin);
                if (side.distance <= radius_ + skin_) {
                    if (count_ + touched == max_contact_planes) return false;
                    scratch_.touched_[touched++] = side;
                    continue;
                }
            }
            const auto t = touch_time(triangle.corners, radius_, begin, motion, skin_);
            if (!t || *t > first || (*t == first && wall->id < triangle.id)) continue;
            first = *t;
            wall = &triangle;
        }
        if (!add_touched(id, object.now, touched, blocked)) return false;
        if (wall == nullptr) return true;
        blocked = true;
        return add_wall(id, object.now, side_of(*wall, begin + first * motion));
    }

    /// Like begin_sweep(), of an object whose triangles move in its own frame. A plane separates the
    /// proxy from its triangle for the whole motion, so that no triangle is tested again that has one.
    bool begin_changing_sweep(ObjectId id, const SceneObject& object, const Vec3& begin,
                              const Vec3& motion, bool& blocked) noexcept
    {
        const double reach = radius_ + 2 * skin_;
        near_of_ = ObjectId{max_scene_objects}; // what is kept of another object is overwritten
        const std::size_t found =
            scene_.collect_changing(id, begin, motion, reach, scratch_.near_, scratch_.changing_);
        if (found > scratch_.changing_.size()) return false;
        double first = 2;
        const MovingTriangle* wall = nullptr;
        std::size_t touched = 0;
        for (const MovingTriangle& triangle : std::span(scratch_.changing_).first(found)) {
            if (is_wall(scene_triangle(id, triangle.id))) continue;
            const Vec3 closest = closest_point(triangle.before, begin).point;
            if ((closest - begin).norm() <= radius_ + skin_) {
                const auto plane = separating_plane(triangle, radius_, begin, motion, 0);
                if (!plane || count_ + touched == max_contact_planes) return false;
                scratch_.touched_[touched++] = {triangle.id, plane->normal, plane->point};
                continue;
            }
            const auto t = touch_time(triangle, radius_, begin, motion, skin_ / 2);
            if (!t || *t > first || (*t == first && wall->id < triangle.id)) continue;
            first = *t;
            wall = &triangle;
        }
        if (!add_touched(id, object.now, touched, blocked)) return false;
        if (wall == nullptr) return true;
        blocked = true;
        const auto plane = separating_plane(*wall, radius_, begin, motion, first);
        return plane && add_wall(id, object.now, {wall->id, plane->normal, plane->point});
    }

    /// Adds planes of contacts from before the motion: the proxy slides along them or leaves them.
    /// Sorts by id, for surfaces return triangles in any order, and the order of planes changes the
    /// rounding. False where there are too many.
    bool add_touched(ObjectId id, const RigidTransform& pose, std::size_t touched,
                     bool& blocked) noexcept
    {
        const auto sides = std::span(scratch_.touched_).first(touched);
        std::ranges::sort(sides, {}, &CarryScratch::Side::triangle);
        for (const CarryScratch::Side& side : sides) {
            if (!add_wall(id, pose, side)) return false;
            blocked = true;
        }
        return true;
    }

    /// Collects all triangles within `reach` of a path in the object's frame. False where there are
    /// too many.
    bool collect(ObjectId id, const SceneObject& object, const Vec3& begin, const Vec3& motion,
                 double reach) noexcept
    {
        const bool has_them = near_count_ <= scratch_.near_.size() && near_of_ == id &&
                              (motion - near_motion_).norm() + reach <= near_reach_;
        if (has_them) return true;
        near_of_ = id;
        near_motion_ = motion;
        near_reach_ = reach + slack_in_edges * object.body->surface().scale().mean_edge;
        near_count_ = scene_.collect_of(id, begin, motion, near_reach_, scratch_.near_);
        if (near_count_ <= scratch_.near_.size()) return true;
        near_reach_ = reach;
        near_count_ = scene_.collect_of(id, begin, motion, reach, scratch_.near_);
        return near_count_ <= scratch_.near_.size();
    }

    static CarryScratch::Side side_of(const ContactTriangle& triangle, const Vec3& p) noexcept
    {
        const TrianglePoint closest = closest_point(triangle.corners, p);
        const Vec3 away = p - closest.point;
        CarryScratch::Side side;
        side.triangle = triangle.id;
        side.point = closest.point;
        side.distance = away.norm();
        if (closest.part == TrianglePart::inside || !(side.distance > 0)) {
            side.normal = unit_normal(triangle.corners);
            if (side.normal.dot(away) < 0) side.normal = -side.normal;
        } else {
            side.normal = away / side.distance;
        }
        return side;
    }

    [[nodiscard]] bool is_wall(TriangleId triangle) const noexcept
    {
        const auto walls = std::span(scratch_.walls_).first(count_);
        return std::find(walls.begin(), walls.end(), triangle) != walls.end();
    }

    bool add_wall(ObjectId id, const RigidTransform& pose, const CarryScratch::Side& side) noexcept
    {
        if (count_ == max_contact_planes) return false;
        const Vec3 normal = pose.rotation * side.normal;
        scratch_.walls_[count_] = scene_triangle(id, side.triangle);
        scratch_.planes_[count_++] = {normal, normal.dot(goal_ - pose(side.point)) - radius_};
        return true;
    }

    const MovingSurface& scene_;
    double radius_;
    double skin_;
    Vec3 from_;
    Vec3 goal_;
    CarryScratch& scratch_;
    std::size_t count_ = 0;
    std::size_t near_count_ = 0; ///< of the object `near_of_`
    ObjectId near_of_{max_scene_objects};
    Vec3 near_motion_ = Vec3::Zero();
    double near_reach_ = 0;
};

std::optional<Vec3> move_with_objects(const MovingSurface& scene, double radius, const Vec3& from,
                                      const Vec3& goal, CarryScratch& scratch) noexcept
{
    return Carry(scene, radius, from, goal, scratch).run();
}

CarriedGoal carried_position(const MovingSurface& scene, double radius,
                             std::span<const Contact> contacts, const Vec3& p,
                             CarryScratch& scratch) noexcept
{
    std::array<Vec3, std::tuple_size_v<decltype(SlideResult::contacts)>> ways;
    Vec3 sum = Vec3::Zero();
    double pressures = 0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const Contact& contact = contacts[i];
        const SceneObject object = scene.object(object_of(contact.triangle));
        ways[i] = Vec3::Zero();
        if (object.moved || object.changed) {
            const Vec3 local = to_local(object.before, p);
            const Vec3 taken = object.changed
                                   ? Carry::taken(scene, contact.triangle, radius, local, scratch)
                                   : local;
            ways[i] = object.now(taken) - p;
            sum += contact.pressure * ways[i];
        }
        pressures += contact.pressure;
    }
    if (!(pressures > 0)) return {p, 0, 0};
    const Vec3 way = sum / pressures;
    CarriedGoal goal{p + way, way.norm(), 0};
    for (const Vec3& each : std::span(ways).first(contacts.size()))
        goal.spread = std::max(goal.spread, (each - way).norm());
    return goal;
}

} // namespace proxima
