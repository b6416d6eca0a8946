#include "lab/quality_report.h"

#include "geometry/exact_predicates.h"
#include "geometry/triangle_contact.h"
#include "haptics/proxy/slide_sphere.h"
#include "haptics/scene/object_trajectory.h"
#include "haptics/scene/touch_access.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace proxima {

namespace {

double degrees_between(const Vec3& a, const Vec3& b) noexcept
{
    return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

} // namespace

QualityMeter::QualityMeter(const ContactSurface& surface, WorkspaceMap map)
    : surface_(surface), map_(std::move(map)), near_(SlideScratch::triangles)
{}

QualityMeter::QualityMeter(const TouchScene& scene, const WorkspaceMap& map)
    : QualityMeter(static_cast<const ContactSurface&>(moving_surface(scene)), map)
{
    scene_ = &moving_surface(scene);
    report_.objects.resize(scene.object_count());
}

/// Whether a segment meets a triangle.
bool QualityMeter::passes(const ContactSurface& surface, const Vec3& from, const Vec3& to) noexcept
{
    if (from == to) return false;
    const double half = 0.5 * (to - from).norm() * (1 + 0x1p-40);
    const Vec3 middle = 0.5 * from + 0.5 * to;
    if (surface.clearance(middle) > half) return false;
    const std::size_t found = surface.collect(middle, half, near_);
    for (const ContactTriangle& near : std::span(near_).first(std::min(found, near_.size()))) {
        if (!is_degenerate(near.corners) && segment_meets_triangle(from, to, near.corners))
            return true;
    }
    return false;
}

/// Like passes() of a surface, in the frame of an object, without the cache of its scene.
bool QualityMeter::passes(const ContactBody& body, const Vec3& from, const Vec3& to) noexcept
{
    const Box& bounds = body.bounds();
    const bool is_aside = (from.cwiseMax(to).array() < bounds.lower.array()).any() ||
                          (from.cwiseMin(to).array() > bounds.upper.array()).any();
    return !is_aside && passes(body.surface(), from, to);
}

bool QualityMeter::passes_standing(const Vec3& from, const Vec3& to) noexcept
{
    if (scene_ == nullptr) return passes(surface_, from, to);
    for (std::uint32_t i = 0; i < scene_->object_count(); ++i) {
        const SceneObject object = scene_->object(ObjectId{i});
        if (passes(*object.body, to_local(object.now, from), to_local(object.now, to))) return true;
    }
    return false;
}

void QualityMeter::count_passes(std::span<const Vec3> path) noexcept
{
    for (std::size_t i = 1; i < path.size(); ++i)
        report_.passes += passes_standing(path[i - 1], path[i]) ? 1U : 0U;
}

/// Tests the path on which moving objects carried the proxy, in the frame of each.
void QualityMeter::count_carried(const RenderTick& tick, std::span<const Vec3> path) noexcept
{
    const bool carried = report_.ticks > 1 && last_.is_placed && tick.is_placed && !tick.squeezed &&
                         tick.fault == InputFault::none && !path.empty();
    if (!carried) return;
    for (std::uint32_t i = 0; i < scene_->object_count(); ++i) {
        const SceneObject object = scene_->object(ObjectId{i});
        const Vec3 from = to_local(object.before, last_.proxy);
        const Vec3 to = to_local(object.now, path.front());
        report_.passes += passes(*object.body, from, to) ? 1U : 0U;
    }
}

void QualityMeter::add_objects(const RenderTick& tick) noexcept
{
    bool moved = false;
    for (std::uint32_t i = 0; i < scene_->object_count(); ++i) {
        const SceneObject object = scene_->object(ObjectId{i});
        ObjectQuality& sum = report_.objects[i];
        sum.moving_ticks += object.moved ? 1U : 0U;
        moved |= object.moved;
        if (tick.hold == Hold::free) continue;
        const auto contacts = std::span(tick.contacts).first(tick.contact_count);
        const bool holds =
            std::any_of(contacts.begin(), contacts.end(), [&](const ContactPoint& each) {
                return object_of(each.triangle) == ObjectId{i};
            });
        if (!holds) continue;
        ++sum.touching_ticks;
        const double speed = scene_->velocity_at(ObjectId{i}, tick.proxy).norm();
        sum.max_carrying = std::max(sum.max_carrying, speed / map_.units_per_metre);
    }
    report_.moving_ticks += moved ? 1U : 0U;
    report_.squeezed_ticks += tick.squeezed ? 1U : 0U;
}

void QualityMeter::add(const RenderTick& tick, const Vec3& velocity,
                       std::span<const Vec3> path) noexcept
{
    QualityReport& sum = report_;
    const bool first = sum.ticks == 0;
    const bool touching = tick.hold != Hold::free;
    ++sum.ticks;
    sum.touching_ticks += touching ? 1U : 0U;
    sum.sticking_ticks += tick.hold == Hold::sticking ? 1U : 0U;
    sum.limited_ticks += tick.slide_end == SlideEnd::limited ? 1U : 0U;
    sum.overloaded_ticks += tick.slide_end == SlideEnd::overloaded ? 1U : 0U;
    const bool unwell = tick.condition != InputCondition::well &&
                        tick.condition != InputCondition::clutched &&
                        tick.condition != InputCondition::released;
    sum.faulty_ticks += tick.fault != InputFault::none || unwell ? 1U : 0U;
    sum.max_force = std::max(sum.max_force, tick.force.norm());
    sum.max_spring = std::max(sum.max_spring, tick.spring.norm());
    sum.max_depth = std::max(sum.max_depth, tick.depth / map_.units_per_metre);
    sum.max_speed = std::max(sum.max_speed, velocity.norm());
    sum.max_moves = std::max<std::uint64_t>(sum.max_moves, tick.moves);
    sum.moves += tick.moves;
    count_passes(path);
    if (scene_ != nullptr) {
        count_carried(tick, path);
        add_objects(tick);
    }
    const bool placed = last_.fault != InputFault::not_finite;
    if (!first && placed && tick.fault == InputFault::none) {
        const Vec3 step = tick.position - last_.position;
        sum.taken_energy -= 0.5 * (tick.force + last_.force).dot(step);
        if (touching && last_.hold != Hold::free) {
            const double moved =
                (tick.proxy - last_.proxy).norm() / map_.units_per_metre + step.norm();
            const Vec3 stretch = tick.anchor - map_.to_model(tick.position);
            const Vec3 last_stretch = last_.anchor - map_.to_model(last_.position);
            const double change = (stretch - last_stretch).norm() / map_.units_per_metre;
            constexpr double least = 1e-7; // m: shorter steps may be due to the safety gap
            if (moved > least) sum.max_step_ratio = std::max(sum.max_step_ratio, change / moved);
            if (tick.spring.norm() > 0 && last_.spring.norm() > 0) {
                sum.max_turn_degrees =
                    std::max(sum.max_turn_degrees, degrees_between(tick.spring, last_.spring));
            }
        }
    }
    last_ = tick;
}

} // namespace proxima
