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

double squared_distance(const Box& box, const Vec3& p) noexcept
{
    return (box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0).squaredNorm();
}

/// How much of a change is done.
double part_of(const SceneShape& shape, SceneTime time) noexcept
{
    const double changing = seconds_between(shape.start, time);
    // The sum of ticks may be less than the wanted time by a few roundings.
    const double whole = shape.change->seconds();
    return changing < whole * (1 - 1e-9) ? std::max(changing / whole, 0.0) : 1;
}

ChangingParts parts_of(const SceneShape& shape) noexcept
{
    return shape.change == nullptr ? shape.body->parts() : shape.change->parts();
}

} // namespace

MovingSurface::MovingSurface(SceneInput& input, std::size_t tool)
    : input_(input), tool_(tool), clock_(tool)
{
    const Box& bounds = input.bounds();
    scale_.extent = bounds.extent().maxCoeff();
    scale_.reach = std::max(bounds.lower.cwiseAbs().maxCoeff(), bounds.upper.cwiseAbs().maxCoeff());
    scale_.mean_edge = scale_.extent;
    start();
    try {
        for (std::uint32_t i = 0; i < input.object_count(); ++i) add(ObjectId{i});
    } catch (...) {
        input.leave(tool); // which refers to shapes that end here
        throw;
    }
}

void MovingSurface::start() noexcept
{
    clock_.start(input_.clock());
    for (const auto& slot : objects_) {
        if (slot->courses.update()) slot->trajectory.follow(slot->courses.reading());
        slot->trajectory.start(clock_.now());
        slot->free_ball.reach = -1;
    }
    edition_ = new_edition();
}

void MovingSurface::measure() noexcept
{
    double least = scale_.extent;
    for (const auto& slot : objects_) least = std::min(least, slot->surface().scale().mean_edge);
    scale_.mean_edge = std::max(least, least_edge * scale_.extent);
}

void MovingSurface::add(ObjectId id)
{
    PROXIMA_CHECK_EQ(to_index(id), objects_.size());
    auto slot = std::make_unique<Slot>(input_.courses(id, tool_), input_.materials(id, tool_));
    slot->courses.update();
    slot->materials.update();
    slot->trajectory = ObjectTrajectory(slot->courses.reading(), clock_.now());
    objects_.reserve(objects_.size() + 1); // nothing throws once the input refers to the shapes
    input_.join(id, tool_, slot->shapes);
    slot->shapes.update();
    const SceneShape& shape = slot->shapes.reading();
    if (shape.change != nullptr) {
        slot->part = part_of(shape, clock_.now());
        slot->shape.set(shape.change->parts(), slot->part);
    }
    // Positions are rounded in the object's frame, too.
    scale_.reach = std::max(scale_.reach, slot->surface().scale().reach);
    rounding_ = frame_rounding * scale_.reach;
    objects_.push_back(std::move(slot));
    measure();
    edition_ = new_edition();
}

bool MovingSurface::advance_shape(Slot& slot, SceneTime time) noexcept
{
    slot.stretch = 0;
    const bool is_new = slot.shapes.update();
    const SceneShape& shape = slot.shapes.reading();
    const SceneShape& last = is_new ? slot.shapes.before() : shape;
    const bool exchanged = shape.exchanges != last.exchanges;
    const double before = slot.part;
    const bool changes = shape.change != nullptr && (is_new || before != 1);
    if (exchanged || changes) slot.shape_before.set(parts_of(last), before);
    if (shape.change == nullptr) slot.part = 1;
    if (!changes) return exchanged;
    slot.part = part_of(shape, time);
    slot.shape.set(shape.change->parts(), slot.part);
    if (exchanged) return true;
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
    tick.seconds = clock_.advance(input_.clock(), seconds);
    tick_seconds_ = tick.seconds;
    for (const auto& slot : objects_) {
        if (slot->courses.update()) slot->trajectory.follow(slot->courses.reading());
        slot->trajectory.advance(clock_.now());
        (void)slot->materials.update();
        slot->exchanged = advance_shape(*slot, clock_.now());
        slot->free_ball.reach -= slot->stretch;
        if (slot->trajectory.moved() || slot->exchanged) slot->free_ball.reach = -1;
        slot->free_path = {};
        tick.moved |= slot->trajectory.moved() || slot->stretch > 0;
        tick.exchanged |= slot->exchanged;
    }
    if (tick.exchanged) measure();
    if (tick.moved || tick.exchanged) edition_ = new_edition();
    return tick;
}

SceneObject MovingSurface::object(ObjectId id) const noexcept
{
    const Slot& slot = *objects_[to_index(id)];
    return {&slot.body(),          slot.trajectory.before(),
            slot.trajectory.now(), slot.trajectory.moved(),
            slot.stretch > 0,      slot.exchanged};
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

Vec3 MovingSurface::exit_from(const Slot& slot, const Vec3& local) const noexcept
{
    if (slot.part < 1) return local; // the body's inside is not that of a shape on its way to it
    const auto out = slot.body().nearest_exit(local);
    return out ? beyond(*out, local, safety_gap(scale_)) : local;
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
            const Vec3 outside = exit_from(*slot, local);
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

bool MovingSurface::is_apart(ObjectId id, const Vec3& p, double distance) const noexcept
{
    const Slot& slot = *objects_[to_index(id)];
    const Vec3 local = to_local(slot.trajectory.now(), p);
    if (!(slot.surface().clearance(local) - frame_margin(p) > distance)) return false;
    return exit_from(slot, local) == local;
}

bool MovingSurface::was_apart(ObjectId id, const Vec3& p, double distance) const noexcept
{
    const Slot& slot = *objects_[to_index(id)];
    const Vec3 local = to_local(slot.trajectory.before(), p);
    return slot.shape_before.clearance(local) - frame_margin(p) > distance;
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
    const Slot& slot = *objects_[to_index(object_of(triangle))];
    const auto given = slot.materials.reading().at(slot.shapes.reading().exchanges, clock_.now());
    return given ? given : slot.body().material();
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
