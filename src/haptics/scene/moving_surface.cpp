#include "haptics/scene/moving_surface.h"

#include "base/check.h"
#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"
#include "haptics/proxy/slide_sphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

/// Several times the rounding of a position that is moved between frames, in parts of the reach of
/// the bounds; a slide's skin is 2^-42 of it.
constexpr double frame_rounding = 0x1p-47;

/// More than the rounding of the distances of a body and of its box, in parts of coordinates.
constexpr double box_rounding = 0x1p-44;

bool is_rigid(const RigidTransform& pose)
{
    const Mat3& r = pose.rotation;
    if (!r.allFinite() || !pose.translation.allFinite()) return false;
    return (r.transpose() * r - Mat3::Identity()).norm() <= rigid_tolerance && r.determinant() > 0;
}

bool in_range(const ObjectMotion& motion)
{
    return std::isfinite(motion.seconds) && motion.seconds >= 0 && motion.velocity.allFinite() &&
           motion.spin.allFinite() && std::isfinite(motion.coast_seconds) &&
           motion.coast_seconds >= 0;
}

double squared_distance(const Box& box, const Vec3& p) noexcept
{
    return (box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0).squaredNorm();
}

} // namespace

MovingSurface::MovingSurface(const Box& bounds) : bounds_(bounds)
{
    PROXIMA_CHECK((bounds.extent().array() > 0).all());
    scale_.extent = bounds.extent().maxCoeff();
    scale_.reach = std::max(bounds.lower.cwiseAbs().maxCoeff(), bounds.upper.cwiseAbs().maxCoeff());
    scale_.mean_edge = scale_.extent;
    rounding_ = frame_rounding * scale_.reach;
}

bool MovingSurface::contains(const Box& bounds, const RigidTransform& pose) const
{
    for (unsigned corner = 0; corner < 8; ++corner) {
        Vec3 p;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<Eigen::Index>(axis);
            p[i] = (corner >> axis & 1U) != 0 ? bounds.upper[i] : bounds.lower[i];
        }
        const Vec3 at = pose(p);
        if ((at.array() < bounds_.lower.array()).any() ||
            (at.array() > bounds_.upper.array()).any())
            return false;
    }
    return true;
}

void MovingSurface::measure() noexcept
{
    double least = scale_.extent;
    for (const auto& slot : objects_) least = std::min(least, slot->surface().scale().mean_edge);
    scale_.mean_edge = least;
}

Result<ObjectId> MovingSurface::add(std::shared_ptr<const ContactBody> body,
                                    const RigidTransform& pose)
{
    PROXIMA_CHECK(body != nullptr);
    if (objects_.size() == max_scene_objects)
        return fail(ErrorCode::invalid_argument, "a scene cannot have more than 64 objects");
    if (!is_rigid(pose))
        return fail(ErrorCode::invalid_argument, "the object's pose must be a rigid transform");
    if (!contains(body->bounds(), pose))
        return fail(ErrorCode::invalid_argument, "the object must be within the scene's bounds");
    auto slot = std::make_unique<Slot>();
    slot->newest.body = std::move(body);
    slot->newest_pose = pose;
    slot->shapes.writing() = slot->newest;
    slot->shapes.publish();
    slot->shapes.update();
    slot->trajectory = ObjectTrajectory(pose);
    objects_.push_back(std::move(slot));
    measure();
    edition_ = new_edition();
    return ObjectId{static_cast<std::uint32_t>(objects_.size() - 1)};
}

Status MovingSurface::move(ObjectId object, const ObjectMotion& motion)
{
    PROXIMA_CHECK_LT(to_index(object), objects_.size());
    Slot& slot = *objects_[to_index(object)];
    if (!is_rigid(motion.pose))
        return fail(ErrorCode::invalid_argument, "the object's pose must be a rigid transform");
    if (!in_range(motion)) {
        return fail(ErrorCode::invalid_argument,
                    "times of a motion must be finite and not negative, and its velocities finite");
    }
    const RigidTransform end = {motion.pose.rotation,
                                motion.pose.translation + motion.coast_seconds * motion.velocity};
    const Box& bounds = slot.newest.body->bounds();
    if (!contains(bounds, motion.pose) || !contains(bounds, end))
        return fail(ErrorCode::invalid_argument,
                    "the motion would take the object out of the scene's bounds");
    slot.newest_pose = motion.pose;
    slot.motions.writing() = motion;
    slot.motions.publish();
    return {};
}

Status MovingSurface::exchange(ObjectId object, std::shared_ptr<const ContactBody> body)
{
    PROXIMA_CHECK_LT(to_index(object), objects_.size());
    PROXIMA_CHECK(body != nullptr);
    Slot& slot = *objects_[to_index(object)];
    if (!contains(body->bounds(), slot.newest_pose))
        return fail(ErrorCode::invalid_argument,
                    "the new body would not be within the scene's bounds");
    const std::uint64_t exchanges = slot.newest.exchanges + 1;
    slot.newest = {};
    slot.newest.body = std::move(body);
    slot.newest.exchanges = exchanges;
    slot.shapes.writing() = slot.newest; // frees what the servo loop has left
    slot.shapes.publish();
    return {};
}

Status MovingSurface::change_shape(ObjectId object, std::shared_ptr<const ContactBody> body,
                                   double seconds)
{
    PROXIMA_CHECK_LT(to_index(object), objects_.size());
    PROXIMA_CHECK(body != nullptr);
    Slot& slot = *objects_[to_index(object)];
    if (!body->has_triangles_of(*slot.newest.body)) {
        return fail(ErrorCode::invalid_argument,
                    "the body is no refit of the object's: use refit_touch_body, or exchange()");
    }
    if (!(seconds >= 0) || !std::isfinite(seconds)) {
        return fail(ErrorCode::invalid_argument,
                    "the time of a change must be finite and at least 0");
    }
    if (!contains(body->bounds(), slot.newest_pose)) {
        return fail(ErrorCode::invalid_argument,
                    "the new shape would not be within the scene's bounds");
    }
    auto change = ShapeChange::make(slot.newest.body, body, seconds);
    if (!change) return tl::unexpected(change.error());
    slot.newest.travelled += (*change)->farthest();
    slot.newest.body = std::move(body);
    slot.newest.change = std::move(*change);
    slot.shapes.writing() = slot.newest; // frees what the servo loop has left
    slot.shapes.publish();
    return {};
}

bool MovingSurface::advance_shape(Slot& slot, double seconds) noexcept
{
    slot.stretch = 0;
    const bool is_new = slot.shapes.update();
    const Shape& shape = slot.shapes.reading();
    const Shape& last = is_new ? slot.shapes.before() : shape;
    const bool exchanged = shape.exchanges != last.exchanges;
    if (is_new) slot.changing = 0;
    if (shape.change == nullptr) slot.part = 1;
    if (shape.change == nullptr || (!is_new && slot.part == 1)) return exchanged;
    const double before = slot.part;
    slot.changing += seconds;
    // The sum of ticks may be less than the wanted time by a few roundings.
    const double whole = shape.change->seconds();
    slot.part = slot.changing < whole * (1 - 1e-9) ? slot.changing / whole : 1;
    slot.shape.set(shape.change->parts(), slot.part);
    if (exchanged) return true;
    slot.shape_before.set(last.change == nullptr ? last.body->parts() : last.change->parts(),
                          before);
    const double farthest = shape.change->farthest();
    if (!is_new) {
        slot.stretch = (slot.part - before) * farthest;
        return false;
    }
    // The rest of the last change, what changes moved that came and went within a tick, and a part
    // of this one.
    const double left = last.change == nullptr ? 0 : (1 - before) * last.change->farthest();
    const double between = shape.travelled - farthest - last.travelled;
    slot.stretch = left + std::max(between, 0.0) + slot.part * farthest + 0x1p-50 * shape.travelled;
    return false;
}

SceneTick MovingSurface::advance(double seconds) noexcept
{
    SceneTick tick;
    tick_seconds_ = seconds;
    for (const auto& slot : objects_) {
        if (slot->motions.update()) slot->trajectory.follow(slot->motions.reading());
        slot->trajectory.advance(seconds);
        const bool exchanged = advance_shape(*slot, seconds);
        slot->free_ball.reach -= slot->stretch;
        if (slot->trajectory.moved() || exchanged) slot->free_ball.reach = -1;
        slot->free_path = {};
        tick.moved |= slot->trajectory.moved() || slot->stretch > 0;
        tick.exchanged |= exchanged;
    }
    if (tick.exchanged) measure();
    if (tick.moved || tick.exchanged) edition_ = new_edition();
    return tick;
}

SceneObject MovingSurface::object(ObjectId id) const noexcept
{
    const Slot& slot = *objects_[to_index(id)];
    return {&slot.body(), slot.trajectory.before(), slot.trajectory.now(), slot.trajectory.moved(),
            slot.stretch > 0};
}

Vec3 MovingSurface::velocity_at(ObjectId id, const Vec3& p) const noexcept
{
    const ObjectTrajectory& trajectory = objects_[to_index(id)]->trajectory;
    if (!trajectory.moved()) return Vec3::Zero();
    return (p - trajectory.before()(to_local(trajectory.now(), p))) / tick_seconds_;
}

Vec3 MovingSurface::velocity_at(TriangleId triangle, const Vec3& p) const noexcept
{
    const Slot& slot = *objects_[to_index(object_of(triangle))];
    if (!(slot.stretch > 0)) return velocity_at(object_of(triangle), p);
    const Vec3 local = to_local(slot.trajectory.now(), p);
    const MovingTriangle moving = changing_triangle(triangle);
    const TrianglePoint at = closest_point(moving.now, local);
    const Vec3 moved = at.point - point_at(moving.before, at.weights);
    return (p - slot.trajectory.before()(local - moved)) / tick_seconds_;
}

double MovingSurface::frame_margin(const Vec3& p) const noexcept
{
    return rounding_ + frame_rounding * p.cwiseAbs().maxCoeff();
}

Vec3 MovingSurface::nearest_exit(const Vec3& p) const noexcept
{
    Vec3 position = p;
    constexpr int attempts = 4;
    for (int attempt = 0; attempt < attempts; ++attempt) {
        bool inside = false;
        for (const auto& slot : objects_) {
            const RigidTransform& pose = slot->trajectory.now();
            const Vec3 local = to_local(pose, position);
            const auto out = slot->body().nearest_exit(local);
            if (!out) continue;
            const Vec3 outside = beyond(*out, local, safety_gap(scale_));
            if (outside == local) continue;
            position = pose(outside);
            inside = true;
        }
        if (!inside) break;
    }
    return position;
}

double MovingSurface::known_clearance(Slot& slot, const Vec3& local) const noexcept
{
    const ContactSurface& surface = slot.surface();
    const double rounding = box_rounding * (surface.scale().reach + local.cwiseAbs().maxCoeff());
    const double box = std::sqrt(squared_distance(slot.bounds(), local)) - rounding;
    return std::max(box, slot.cache.known_clearance(surface, local));
}

bool MovingSurface::keeps_clear(ObjectId id, const Vec3& from, const Vec3& to,
                                double distance) const noexcept
{
    Slot& slot = *objects_[to_index(id)];
    const FreePath& known = slot.free_path;
    if (known.is_near) return false;
    const double margin = 4 * frame_margin(from) + 4 * frame_margin(to);
    const double aside = (from - known.from).norm();
    const double length = known.length + aside + (to - known.to).norm();
    if (known.reach > distance + aside + length + margin) return true;
    const Vec3 begin = to_local(slot.trajectory.before(), from);
    const double moved = (to_local(slot.trajectory.now(), to) - begin).norm();
    // Search the triangles where they are now. No triangle has moved farther than the stretch.
    double reach = known_clearance(slot, begin) - slot.stretch;
    // The ball, which the stretch made smaller, was free all the time.
    if (!slot.trajectory.moved())
        reach = std::max(reach, slot.free_ball.reach - (from - slot.free_ball.center).norm());
    const bool is_clear = reach > distance + moved + margin;
    slot.free_path = {from, to, moved, reach, !is_clear};
    slot.free_ball = {to, reach - moved - margin};
    return is_clear;
}

std::size_t MovingSurface::collect_of(ObjectId id, const Vec3& p, const Vec3& motion,
                                      double distance,
                                      std::span<ContactTriangle> buffer) const noexcept
{
    Slot& slot = *objects_[to_index(id)];
    return slot.cache.collect_along(slot.surface(), p, motion, distance, buffer);
}

MovingTriangle MovingSurface::changing_triangle(TriangleId triangle) const noexcept
{
    const Slot& slot = *objects_[to_index(object_of(triangle))];
    const TriangleId id = triangle_of(triangle);
    return {slot.shape_before.triangle(id), slot.shape.triangle(id), id};
}

std::size_t MovingSurface::collect_changing(ObjectId id, const Vec3& p, const Vec3& motion,
                                            double distance, std::span<ContactTriangle> near,
                                            std::span<MovingTriangle> buffer) const noexcept
{
    const Slot& slot = *objects_[to_index(id)];
    const double around = distance + slot.stretch;
    const std::size_t found = slot.shape_before.collect_along(p, motion, around, near);
    if (found > near.size()) return std::max(found, buffer.size() + 1);
    const Vec3 end = p + motion;
    const Vec3 lower = p.cwiseMin(end) - Vec3::Constant(distance);
    const Vec3 upper = p.cwiseMax(end) + Vec3::Constant(distance);
    std::size_t count = 0;
    for (const ContactTriangle& triangle : near.first(found)) {
        const Triangle now = slot.shape.triangle(triangle.id);
        Box box = bounding_box(triangle.corners);
        for (const Vec3& corner : now.vertices) box.extend(corner);
        const bool is_aside =
            (box.lower.array() > upper.array()).any() || (box.upper.array() < lower.array()).any();
        if (is_aside) continue;
        if (count < buffer.size()) buffer[count] = {triangle.corners, now, triangle.id};
        ++count;
    }
    return count;
}

std::size_t MovingSurface::collect_along(const Vec3& p, const Vec3& motion, double distance,
                                         std::span<ContactTriangle> buffer) const noexcept
{
    std::size_t count = 0;
    const double margin = frame_margin(p) + frame_margin(motion);
    const double near = distance + margin;
    const double around = near + motion.norm() + margin;
    for (std::uint32_t i = 0; i < objects_.size(); ++i) {
        Slot& slot = *objects_[i];
        if (slot.free_ball.reach > around + (p - slot.free_ball.center).norm()) continue;
        const RigidTransform& pose = slot.trajectory.now();
        const Vec3 local = to_local(pose, p);
        const double known = known_clearance(slot, local);
        slot.free_ball = {p, known - margin};
        if (known > around) continue;
        const Vec3 local_motion = pose.rotation.transpose() * motion;
        const auto left = buffer.subspan(std::min(count, buffer.size()));
        const std::size_t found = collect_of(ObjectId{i}, local, local_motion, near, left);
        for (ContactTriangle& triangle : left.first(std::min(found, left.size())))
            triangle = {pose(triangle.corners), scene_triangle(ObjectId{i}, triangle.id)};
        count += found;
    }
    return count;
}

double MovingSurface::clearance(const Vec3& p) const noexcept
{
    double least = std::numeric_limits<double>::infinity();
    for (const auto& slot : objects_) {
        const Vec3 local = to_local(slot->trajectory.now(), p);
        if (squared_distance(slot->bounds(), local) >= least * least) continue;
        least = std::min(least, slot->surface().clearance(local));
    }
    return least - frame_margin(p);
}

double MovingSurface::clearance_beyond(const Vec3& p, double wanted) const noexcept
{
    const double margin = frame_margin(p);
    const double beyond = wanted + margin + 0x1p-50 * std::abs(wanted + margin);
    double least = std::numeric_limits<double>::infinity();
    for (const auto& slot : objects_) {
        // A known bound is enough.
        double known = slot->free_ball.reach - (p - slot->free_ball.center).norm() - margin;
        if (!(known > beyond)) {
            const Vec3 local = to_local(slot->trajectory.now(), p);
            known = known_clearance(*slot, local);
            if (!(known > beyond)) known = slot->cache.clearance(slot->surface(), local, beyond);
            slot->free_ball = {p, known - margin};
        }
        least = std::min(least, known);
    }
    return least - margin;
}

ContactWork MovingSurface::work() const noexcept
{
    ContactWork sum;
    for (const auto& slot : objects_) sum = sum + slot->cache.work();
    return sum;
}

std::optional<SurfaceMaterial> MovingSurface::material(TriangleId triangle) const noexcept
{
    return objects_[to_index(object_of(triangle))]->body().material();
}

const SurfaceTexture* MovingSurface::texture(TriangleId triangle) const noexcept
{
    const auto& texture = objects_[to_index(object_of(triangle))]->body().texture();
    return texture ? &*texture : nullptr;
}

RigidTransform MovingSurface::pose(TriangleId triangle) const noexcept
{
    return objects_[to_index(object_of(triangle))]->trajectory.now();
}

Vec3 MovingSurface::shaded_normal(TriangleId triangle, const Vec3& point) const noexcept
{
    const Slot& slot = *objects_[to_index(object_of(triangle))];
    const ShadingNormals* const normals = slot.body().normals();
    if (normals == nullptr) return Vec3::Zero();
    const RigidTransform& pose = slot.trajectory.now();
    const TriangleId id = triangle_of(triangle);
    const Vec3 local = to_local(pose, point);
    const ShapeChange* const change = slot.shapes.reading().change.get();
    if (change == nullptr) return pose.rotation * normals->shaded_normal(id, local);
    // The normals of both shapes, each at its own point of the triangle.
    const TrianglePoint at = closest_point(slot.shape.triangle(id), local);
    const auto normal_of = [&](const ContactBody& body) {
        return body.normals()->shaded_normal(id, point_at(body.mesh().triangle(id), at.weights));
    };
    const Vec3 sum =
        (1 - slot.part) * normal_of(change->from()) + slot.part * normal_of(change->to());
    const double length = sum.norm();
    return length > 0 ? Vec3(pose.rotation * (sum / length)) : Vec3(Vec3::Zero());
}

} // namespace proxima
