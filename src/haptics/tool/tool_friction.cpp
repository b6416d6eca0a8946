#include "haptics/tool/tool_friction.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// Solutions of a motion: with the loads of the last one, with its own, and once it slides.
constexpr int max_load_rounds = 3;
/// Loads agree that differ by less than this part.
constexpr double loads_agree = 0.01;
/// Friction has its limit beyond this part of it.
constexpr double near_limit = 1 - 1e-6;

} // namespace

ToolFriction::ToolFriction(const FrictionOptions& options, std::size_t most_constraints)
    : options_(options), scratch_(most_constraints)
{}

void ToolFriction::restart() noexcept
{
    loads_.count = 0;
    used_.count = 0;
    hold_ = Hold::free;
}

double ToolFriction::Loads::total() const noexcept
{
    double sum = 0;
    for (const Load& each : std::span(items).first(count)) sum += each.pressure;
    return sum;
}

/// Friction against the loads of the last motion.
void ToolFriction::set_frictions(std::span<const SeenObject> objects) noexcept
{
    used_ = loads_;
    most_friction_ = 0;
    for (std::size_t k = 0; k < used_.count; ++k) {
        const Load& load = used_.items[k];
        const Vec3 arm = pose_.rotation * load.point;
        const SeenObject& object = objects[load.object];
        const Vec3 normal = object.pose.rotation * load.normal;
        const Vec3 side = normal.unitOrthogonal();
        const Vec3 other = normal.cross(side);
        const Vec3 carried =
            object.moves ? object.displacement(pose_.translation + arm) : Vec3(Vec3::Zero());
        MotionFriction& friction = frictions_[k];
        friction.along.row(0) << side.transpose(),
            arm.cross(side).transpose() / options_.turning_length;
        friction.along.row(1) << other.transpose(),
            arm.cross(other).transpose() / options_.turning_length;
        friction.carried = {side.dot(carried), other.dot(carried)};
        const Friction& coefficients = object.friction;
        friction.limit =
            load.pressure * (hold_ == Hold::sliding ? coefficients.sliding : coefficients.fixed);
        most_friction_ += load.pressure * coefficients.fixed;
    }
}

ToolFriction::Loads ToolFriction::loads_of(const ConstrainedMotion& motion,
                                           std::span<const SeenObject> objects,
                                           std::span<const FeatureContact> contacts) const noexcept
{
    Loads loads;
    const Mat3 back = pose_.rotation.transpose();
    for (std::size_t k = 0; k < motion.active_count; ++k) {
        const FeatureContact& contact = contacts[motion.active[k]];
        loads.items[loads.count++] = {back * (contact.tool_point - pose_.translation),
                                      objects[contact.object].pose.rotation.transpose() *
                                          contact.normal,
                                      motion.pressure[k], contact.object};
    }
    return loads;
}

Hold ToolFriction::hold_of(const FrictionalMotion& found) const noexcept
{
    if (found.constrained.active_count == 0) return Hold::free;
    double friction = 0;
    bool slides = false;
    for (std::size_t k = 0; k < used_.count; ++k) {
        const double size = found.friction[k].norm();
        const double slip = frictions_[k].slid(found.constrained.motion).norm();
        friction += size;
        slides = slides || (size >= near_limit * frictions_[k].limit && slip > options_.least_slip);
    }
    const bool has_friction = used_.count == 0 || most_friction_ > 0;
    if (slides || !has_friction) return Hold::sliding;
    const bool sticks_again = friction <= options_.restick * most_friction_;
    return hold_ == Hold::sliding && !sticks_again ? Hold::sliding : Hold::sticking;
}

ConstrainedMotion ToolFriction::solve(const Vec6& wanted, const RigidTransform& pose,
                                      std::span<const SeenObject> objects,
                                      std::span<const FeatureContact> contacts,
                                      std::span<const MotionConstraint> constraints,
                                      double tolerance) noexcept
{
    pose_ = pose;
    steps_ = 0;
    FrictionalMotion found;
    for (int round = 0; round < max_load_rounds; ++round) {
        set_frictions(objects);
        found = least_constraint_with_friction(
            wanted, constraints, std::span(frictions_).first(used_.count), tolerance, scratch_);
        steps_ += found.steps;
        if (!found.constrained.solved) break;
        const Hold before = hold_;
        loads_ = loads_of(found.constrained, objects, contacts);
        hold_ = hold_of(found);
        const double difference = std::abs(loads_.total() - used_.total());
        const bool yields = before != Hold::sliding && hold_ == Hold::sliding;
        if (!yields && difference <= loads_agree * loads_.total()) break;
    }
    return found.constrained;
}

double ToolFriction::loss(const RigidTransform& to) const noexcept
{
    double sum = 0;
    for (std::size_t k = 0; k < used_.count; ++k) {
        const Vec3& point = used_.items[k].point;
        const Vec3 moved = to(point) - pose_(point);
        // The rows have the two directions along the surface.
        sum += frictions_[k].limit * (frictions_[k].along.leftCols<3>() * moved).norm();
    }
    return sum;
}

double ToolFriction::loss(const Vec6& motion) const noexcept
{
    double sum = 0;
    for (std::size_t k = 0; k < used_.count; ++k)
        sum += frictions_[k].limit * (frictions_[k].along * motion).norm();
    return sum;
}

} // namespace proxima
